// SPDX-License-Identifier: Apache-2.0
// Marks what libtessera shows to applications; everything else stays inside (the project is
// compiled with hidden visibility).
// Threads. A macro. Only names that the installed headers promise carry it.
#pragma once

#define TESSERA_API __attribute__((visibility("default")))
