# SPDX-License-Identifier: Apache-2.0
"""The table of all rows by their identifiers, and which of them are the small set."""
import application
import crowds
import cuts
import identity
import joiners
import masters
import messages
import network
import processes
import relays
import results
import scenes

# The rows that run on every change (fault-matrix, "How often").
SMALL = ["F01", "F02", "F05large", "F05poison", "F07", "F13", "F13deaf", "F15", "F25", "F30", "F31", "F32", "F33", "F36", "F39", "F40",
         "F59", "F62"]

ROWS = {}
for group in (processes, crowds, joiners, network, cuts, results, messages, identity, application, masters, scenes, relays):
    ROWS.update(group.ROWS)
