#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Breaks each rule on purpose in a small tree and expects check_sources to say so, in that line."""
import pathlib
import sys
import tempfile
import unittest

import check_sources
import rules

HEADER = "// One.\n// Two.\n#pragma once\n"


class Walls(unittest.TestCase):
    def findings(self, files):
        with tempfile.TemporaryDirectory() as folder:
            for name, text in files.items():
                path = pathlib.Path(folder, name)
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text(text)
            return check_sources.check_tree(folder)[0]

    def expect(self, files, start, words):
        lines = self.findings(files)
        self.assertEqual(len(lines), 1, lines)
        self.assertTrue(lines[0].startswith(start + ":"), lines)
        self.assertIn(words, lines[0])

    def test_a_clean_tree_has_no_findings(self):
        self.assertEqual(self.findings({
            "common/base/a.h": HEADER,
            "common/math/a.h": HEADER + '#include "common/base/a.h"\n',
            "slave/core/simd/a-inl.h": HEADER + '#include <stdint.h>\n#include "hwy/highway.h"\n',
            "slave/core/simd/a.h": HEADER + rules.PLAIN_TEXT + '\n#include "slave/core/simd/a-inl.h"\n',
            "tests/unit/a_test.cpp": '#include "slave/core/simd/a-inl.h"\n#include "master/session/x.h"\n',
        }), [])

    def test_a_broken_arrow_is_red(self):
        self.expect({"common/base/a.h": HEADER + '#include "common/net/b.h"\n'}, "common/base/a.h:4", "common/net -> common/base")
        self.expect({"slave/core/accel/a.cpp": '#include "slave/core/integrate/b.h"\n'}, "slave/core/accel/a.cpp:1", "does not exist")
        self.expect({"slave/core/integrate/a.cpp": '#include "common/net/b.h"\n'}, "slave/core/integrate/a.cpp:1", "does not exist")
        self.expect({"master/schedule/a.cpp": '\n#include "slave/slave_node.h"\n'}, "master/schedule/a.cpp:2", "does not exist")

    def test_a_circle_of_units_is_red(self):
        self.expect({"common/net/a.h": HEADER, "common/net/a.cpp": '#include "common/net/b.h"\n',
                     "common/net/b.h": HEADER + '#include "common/net/c.h"\n',
                     "common/net/c.h": HEADER + '#include "common/net/a.h"\n'},
                    "common/net/c.h:4", "a circle: common/net/a -> common/net/b -> common/net/c -> common/net/a")

    def test_a_source_without_its_licence_is_red(self):
        line = rules.LICENCE_LINE
        kept = {"LICENSE": "", "common/base/a.cpp": f"// {line}\nint a;\n", "tests/a.py": f"#!/usr/bin/env python3\n# {line}\n"}
        self.assertEqual(self.findings(kept), [])
        self.expect({**kept, "common/base/b.cpp": "int a;\n"}, "common/base/b.cpp:1", line)
        self.expect({**kept, "proto/b.proto": f"\n// {line}\n"}, "proto/b.proto:1", line)
        self.expect({**kept, "common/base/c.h": f"// {line}\n// One.\n#pragma once\n"}, "common/base/c.h:1", "a header opens with")

    def test_a_unit_test_that_sleeps_or_listens_is_red(self):
        self.expect({"tests/unit/a.cpp": "std::this_thread::sleep_for(1ms);\n"}, "tests/unit/a.cpp:1", "sleep_for")
        self.expect({"tests/property/a.cpp": '\n#include "common/net/io_thread.h"\n'}, "tests/property/a.cpp:2", "tests/links")
        self.assertEqual(self.findings({"tests/links/a.cpp": '#include "common/net/io_thread.h"\n'}), [])

    def test_a_readme_that_is_no_map_is_red(self):
        self.expect({"slave/README.md": "a\n" * 121}, "slave/README.md:121", "121 lines")
        self.expect({"slave/README.md": "a\n" + "b" * 101}, "slave/README.md:2", "101 columns")
        self.assertEqual(self.findings({"slave/README.md": "|" + "b" * 101 + "|\n"}), [])

    def test_a_speed_in_prose_is_red(self):
        for words in ("5.2 Mrays/s", "12 % slower", "1.6 times\nas fast", "1.1 of Embree", "40 ns a call"):
            self.expect({"slave/a.md": f"A title.\n\nIt reaches {words} here.\n"}, "slave/a.md:3", "is measured")
        for words in ("a time limit of 500 ms", "an error of 0.04 %", "16 times the size", "3 rays"):
            self.assertEqual(self.findings({"slave/a.md": f"It has {words}.\n"}), [])
        marked = "<!-- results: a.json rays -->\n\nIt reaches 5.2 Mrays/s.\n\n<!-- end of results -->\n"
        self.assertEqual(self.findings({"slave/a.md": marked}), [])
        self.assertEqual(self.findings({"slave/a.md": marked.replace("results", "plot")}), [])

    def test_a_measured_table_outside_of_marks_is_red(self):
        table = "| | a | b |\n|---|---|---|\n| c | 1 | 2 |\n"
        self.expect({"slave/core/decisions/a.md": table}, "slave/core/decisions/a.md:1", "a measured table")
        self.assertEqual(self.findings({"slave/core/decisions/a.md": table.replace("1 | 2", "one | two")}), [])

    def test_including_tests_is_red(self):
        self.expect({"common/base/a.cpp": '#include "tests/support/x.h"\n'}, "common/base/a.cpp:1", "tests/")

    def test_a_folder_without_a_rule_is_red(self):
        self.expect({"common/helpers/a.cpp": "int a;\n"}, "common/helpers/a.cpp:1", "table of arrows")

    def test_a_library_outside_its_folder_is_red(self):
        self.expect({"master/session/a.cpp": "#include <asio.hpp>\n"}, "master/session/a.cpp:1", "Asio")
        self.expect({"common/base/b.cpp": "#include <spdlog/spdlog.h>\n"}, "common/base/b.cpp:1", "spdlog")
        self.expect({"slave/a.cpp": "#include <OpenImageIO/imageio.h>\n"}, "slave/a.cpp:1", "OpenImageIO")
        self.expect({"tests/unit/a.cpp": "#include <spdlog/spdlog.h>\n"}, "tests/unit/a.cpp:1", "spdlog")

    def test_a_time_limit_of_a_tests_own_is_red(self):
        self.expect({"tests/unit/CMakeLists.txt": "x\nset_tests_properties(a PROPERTIES TIMEOUT 120)\n"},
                    "tests/unit/CMakeLists.txt:2", "tessera_hang_seconds")
        self.assertEqual(self.findings({"tests/a.cpp": "int a;\n", "tests/CMakeLists.txt":
                                        "set_tests_properties(a PROPERTIES TIMEOUT ${tessera_hang_seconds})\n"}), [])

    def test_a_second_file_with_a_one_file_library_is_red(self):
        self.expect({"slave/a.cpp": "#include <CLI/CLI.hpp>\n", "slave/b.cpp": "#include <CLI/CLI.hpp>\n"}, "slave/b.cpp:1", "CLI11")

    def test_a_folder_that_another_lists_is_red(self):
        tree = {"CMakeLists.txt": "", "common/base/a.cpp": "int x();\n"}
        self.expect(tree, "common/base/a.cpp:1", "common/base has no CMakeLists.txt")
        self.assertEqual(self.findings({**tree, "common/base/CMakeLists.txt": ""}), [])

    def test_a_long_file_is_red(self):
        lines = rules.FILE_LINES_MAX + 1
        self.expect({"common/base/a.cpp": "int x();\n" * lines}, f"common/base/a.cpp:{lines}", "split by meaning")
        self.assertEqual(self.findings({"common/base/a.cpp": "int x();\n" * (lines - 1)}), [])

    def test_a_wide_comment_is_red(self):
        comment = "// " + "x" * (rules.COMMENT_COLUMNS_MAX - 3)
        self.expect({"common/base/a.cpp": comment + "y\nint x();\n"}, "common/base/a.cpp:1", "comment of 101 columns")
        self.assertEqual(self.findings({"common/base/a.cpp": comment + "\nint x();\n"}), [])

    def test_a_long_function_is_red(self):
        body = "  x();\n" * (rules.FUNCTION_LINES_MAX - 1)
        start = "namespace n {\nstruct S {\n  int a = 0;\n};\n"
        self.expect({"common/base/a.cpp": start + "void f(int a,\n       int b) {\n" + body + "}\n}\n"}, "common/base/a.cpp:5", "function of 72 lines")
        self.expect({"tests/unit/a.cpp": "TEST(A, B) {\n" + body + "  y();\n}\n"}, "tests/unit/a.cpp:1", "function of 72 lines")
        self.assertEqual(self.findings({"common/base/a.cpp": start + "void f() {\n" + body[7:] + "}\n}\n"}), [])

    def test_braces_in_text_do_not_count(self):
        body = "  x('{', \"{{{\");  // {\n" * 5
        self.assertEqual(self.findings({"common/base/a.cpp": "void f() {\n" + body + "}\n" + "int y;\n" * 80}), [])

    def test_a_bare_header_is_red(self):
        self.expect({"common/base/a.h": "// One.\n#pragma once\n"}, "common/base/a.h:1", "opens with")
        self.expect({"common/base/a.h": "// One.\n// Two.\n"}, "common/base/a.h:1", "#pragma once")

    def test_a_specialised_variable_that_is_not_inline_is_red(self):
        text = HEADER + "template <class T>\nconstexpr bool kIs = false;\ntemplate <>\nconstexpr bool kIs<int> = true;\n"
        self.expect({"common/base/a.h": text}, "common/base/a.h:7", "inline")
        self.assertEqual(self.findings({"common/base/a.h": text.replace("<>\nconst", "<>\ninline const")}), [])

    def test_what_a_kernel_text_includes(self):
        name = "slave/core/simd/a-inl.h"
        self.expect({name: HEADER + "#include <vector>\n"}, f"{name}:4", "<vector>"[1:-1])
        self.expect({name: HEADER + '#include "common/base/status.h"\n'}, f"{name}:4", "common/base/status.h")

    def test_plain_code_that_takes_a_kernels_text_is_red(self):
        name = "slave/core/simd/a.cpp"
        self.expect({name: '#include "slave/core/simd/a-inl.h"\n'}, name + ":1", rules.PLAIN_TEXT)
        self.expect({name: '#include "slave/core/simd/a-inl.h"\n' + rules.PLAIN_TEXT + "\n"}, name + ":1", rules.PLAIN_TEXT)
        self.assertEqual(self.findings({name: '#include "hwy/highway.h"\n#include "slave/core/simd/a-inl.h"\n'}), [])

    def test_one_name_for_several_instruction_sets_is_red(self):
        name = "slave/core/bsdf/a-inl.h"
        text = HEADER + "TESSERA_BEFORE_TEXT();\nnamespace tessera::core {\nnamespace TESSERA_TEXT {\nint a;\nTESSERA_AFTER_TEXT();\n"
        self.assertEqual(self.findings({name: text}), [])
        self.expect({name: text.replace("namespace TESSERA_TEXT {\n", "")}, name + ":5", "one name")
        self.expect({name: text.replace("TESSERA_BEFORE", "HWY_BEFORE")}, name + ":5", "TESSERA_BEFORE_TEXT")
        self.expect({name: text.replace("TESSERA_AFTER_TEXT();\n", "")}, name + ":5", "behind it")
        self.expect({name: text.replace("int a", "hn::Add a")}, name + ":7", "operators")

    def test_a_word_that_a_folder_does_not_know_is_red(self):
        self.expect({"slave/core/accel/a.cpp": "int x;\n// Of a Triangle.\n"}, "slave/core/accel/a.cpp:2", "know nothing of it")
        self.assertEqual(self.findings({"slave/core/scene/a.cpp": "// Of a triangle.\n"}), [])

    def test_a_machine_path_is_red(self):
        self.expect({"deploy/a.sh": "cd " + "/ho" + "me/someone\n"}, "deploy/a.sh:1", "machine")


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=1))
