# SPDX-License-Identifier: Apache-2.0
"""The table of all rows by their identifiers, and which of them are the small set."""
import application
import identity
import joiners
import messages
import network
import processes
import relays
import results
import scenes

# The rows that run on every change (fault-matrix, "How often").
SMALL = ["F01", "F02", "F05large", "F05poison", "F07", "F13", "F15", "F25", "F30", "F31", "F32", "F33", "F36", "F39", "F40"]

ROWS = {}
for group in (processes, joiners, network, results, messages, identity, application, scenes, relays):
    ROWS.update(group.ROWS)
