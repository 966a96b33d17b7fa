# SPDX-License-Identifier: Apache-2.0
"""The table of all rows by their identifiers, and which of them are the small set."""
import application
import crowds
import cuts
import identity
import joiners
import masters
import messages
import moving
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

# Rows that show a scene which stands still, and concern scenes: they hold while everything moves, too.
WITH_MOTION = ["F01", "F02", "F03", "F08", "F09", "F10", "F13", "F14", "F57", "F57silent", "F57dead", "F57unreachable"]
ROWS.update({name + "moving": moving.while_all_moves(ROWS[name]) for name in WITH_MOTION})
