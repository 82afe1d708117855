#!/usr/bin/env python3
"""Does documents.py see each kind of violation? Each is planted in a small tree of its own."""

import pathlib
import tempfile
import unittest

import documents

SOUND = {
    "README.md": "# A tree\n\nSee [the method](core/METHOD.md#1-ranges) and "
                 "[elsewhere](https://example.org).\n",
    "core/METHOD.md": "# Method\n\n## 1. Ranges\n\n```\nr = 1   (6)\np = 2   (7)\n```\n",
    "core/a.h": "/// Compensated range (METHOD eq 6-7, METHOD 1). 3 seqs 4; not METHODS 9.\n"
                'const char* a = "eq 99"; int eq = 5;  // of METHOD\n/// eq 7\n'
                "struct RadarScan { void TakeColumns(); };\n",
    "core/decisions/0001-a.md": "# 0001 A\n\nShort.\n",
    "core/decisions/README.md": "- [0001](0001-a.md) A\n",
    "build/README.md": "[nowhere](nowhere.md)\n",
}


def violations(planted):
    with tempfile.TemporaryDirectory() as folder:
        for path, text in {**SOUND, **planted}.items():
            file = pathlib.Path(folder, path)
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text)
        return documents.Checker(folder).run()


class DocumentsTest(unittest.TestCase):
    def expect_violation(self, path, text, where, message):
        found = violations({path: text})
        self.assertEqual(len(found), 1, found)
        self.assertTrue(found[0].startswith(where + ": "), found)
        self.assertIn(message, found[0])

    def test_a_sound_tree_is_fine(self):
        self.assertEqual(violations({}), [])

    def test_cited_equations_exist(self):
        self.expect_violation("core/b.h", "\n/// (METHOD eq 8)\n", "core/b.h:2", "no equation 8")
        self.expect_violation("core/b.h", "int a;  // METHOD eq 6, 20\n", "core/b.h:1",
                              "no equation 20")
        self.expect_violation("core/b.cpp", "// as METHOD\n// eq 5-6 says\n", "core/b.cpp:2",
                              "no equation 5")
        self.expect_violation("client/c.py", "# eq 21\n", "client/c.py:1", "no equation 21")
        self.expect_violation("core/README.md", "It is (eq 1).\n", "core/README.md:1",
                              "no equation 1")

    def test_cited_sections_exist(self):
        self.expect_violation("core/b.h", "/// (METHOD 4).\n", "core/b.h:1", "no section 4")
        self.expect_violation("core/b.h", "/// The metrics of METHOD section 8.\n", "core/b.h:1",
                              "no section 8")
        self.expect_violation("core/b.h", "/// what moves is left out (METHOD\n/// 2).\n",
                              "core/b.h:1", "no section 2")

    def test_equations_stand_once_and_are_called_right(self):
        method = SOUND["core/METHOD.md"]
        self.expect_violation("core/METHOD.md", method + "By (7) and (9).\n", "core/METHOD.md:9",
                              "there is no equation 9")
        self.expect_violation("core/METHOD.md", method + "```\nq = 3 (7)\n```\n",
                              "core/METHOD.md:10", "equation 7 stands here again")

    def test_equations_stand_in_order(self):
        method = SOUND["core/METHOD.md"]
        self.expect_violation("core/METHOD.md", method + "```\nq = 3 (5)\n```\n",
                              "core/METHOD.md:10", "equation 5 stands after 7")
        self.assertEqual(violations({"core/METHOD.md": method +
                                     "```\nq = 3 (20)\ns = 4 (8)\nt = 5 (21)\n```\n"}), [])

    def test_the_method_is_there(self):
        found = violations({"core/METHOD.md": "# Empty\n"})
        self.assertTrue(any("no equation 6" in one for one in found), found)

    def test_documents_are_short(self):
        self.expect_violation("README.md", "a\n\n" * 66, "README.md:131", "132 lines, 130 at most")
        self.expect_violation("core/README.md", "a\n" * 81, "core/README.md:81", "81 lines")
        self.expect_violation("core/decisions/0001-a.md", "a\n" * 41, "core/decisions/0001-a.md:41",
                              "41 lines, 40 at most")

    def test_paragraphs_are_short(self):
        words = "word " * 45 + "\n"
        self.assertEqual(violations({"core/b.md": f"{words}{words}\n- {words}  {words}- {words}"}),
                         [])
        self.expect_violation("core/b.md", f"# B\n\n{words}and {words}", "core/b.md:3",
                              "91 words, 90 at most")
        self.expect_violation("core/b.md", f"- short\n- {words}  and {words}", "core/b.md:2",
                              "91 words")
        self.assertEqual(violations({"core/b.md": f"| {words[:-1] * 3} |\n\n```\n{words * 3}```\n"}),
                         [])

    def test_links_lead_somewhere(self):
        self.expect_violation("core/b.md", "\nSee [c](c.md).\n", "core/b.md:2", "nothing is at c.md")
        self.expect_violation("core/b.md", "![picture](../c.svg)\n", "core/b.md:1", "../c.svg")
        self.expect_violation("core/b.md", "[a](METHOD.md#2-points)\n", "core/b.md:1",
                              "no heading is called METHOD.md#2-points")
        self.assertEqual(violations({"core/b.md": "`[c](c.md)`\n\n```\n[c](c.md)\n```\n"}), [])

    def test_each_decision_stands_in_its_index(self):
        record, index = "core/decisions/0001-a.md", "core/decisions/README.md"
        line = "- [0001](0001-a.md) What was decided\n"
        self.assertEqual(violations({record: "", index: line}), [])
        for text, message in [("", "has no line for 0001-a.md"), (line + line, "in line 1, too"),
                              (line.replace("\n", " x" * 60), "at most"),
                              ("| [0001](0001-a.md) What |\n" + line, "a record's line is")]:
            found = violations({record: "", index: text})
            self.assertEqual(len(found), 1, found)
            self.assertIn(message, found[0])

    def test_names_are_those_of_the_tree(self):
        self.expect_violation("core/b.md", "\nIn `core/gone.h`.\n", "core/b.md:2",
                              "nothing is called core/gone.h")
        self.expect_violation("core/b.md", "By `RadarScan::GoneAway()`.\n", "core/b.md:1",
                              "no source knows GoneAway")
        self.assertEqual(violations({
            "core/b.md": "`core/a`, `core/ROOM/x.h`, `RadarScan::TakeColumns`, `RadarScan.TakeCol...`, "
                         "`METHOD`, `Nothing`.\n\n```\nGoneAway core/gone.h\n```\n",
            "server/maps/store/x.h": "", "server/rpc/b.md": "`maps/store/x`",
            "core/decisions/0001-a.md": "Then it was `GoneAway` in `core/gone.h`.\n"}), [])


if __name__ == "__main__":
    unittest.main()
