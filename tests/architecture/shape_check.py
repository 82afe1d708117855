"""The tree's shape: what the top level holds, how long files are, tests where their subject is."""

import os
import statistics

from tree import SOURCES, files

TOP_LEVEL = {"CMakeLists.txt", "CMakePresets.json", "README.md", "LICENSE", "CHANGELOG.md",
             "CONTRIBUTING.md", "proto", "server", "core", "client", "deploy", "tests", "maps"}
NOT_OURS = {"build", "compile_commands.json"}  # made here, and ignored by git

MAX_LINES = 400
MAX_MEDIAN_LINES = {"core": 80, "server": 110, "client": 110}
MIRRORED = ("core", "server", "client")


class ShapeCheck:
    def __init__(self, root, report):
        self.root = root
        self.report = report  # (path, text) of a violation
        self.lengths = {}  # lines of each source

    def run(self):
        self.check_top_level()
        self.check_lengths()
        self.check_mirror()

    def check_top_level(self):
        for entry in sorted(os.listdir(self.root)):
            if not entry.startswith(".") and entry not in TOP_LEVEL | NOT_OURS:
                self.report(entry, "the top level has no place for it")

    def check_lengths(self):
        self.lengths = {path: file.read_text().count("\n")
                        for path, file in files(self.root, *SOURCES)}
        for path, length in self.lengths.items():
            if length > MAX_LINES:
                self.report(path, f"has {length} lines; at most {MAX_LINES}")
        for module, bound in MAX_MEDIAN_LINES.items():
            median = self.median_of(module)
            if median > bound:
                self.report(module, f"its files have a median of {median:g} lines; at most {bound}")

    def median_of(self, module):
        return statistics.median(
            [n for path, n in self.lengths.items() if path.startswith(module + "/")] or [0])

    def figures(self):
        for module, bound in MAX_MEDIAN_LINES.items():
            count = sum(path.startswith(module + "/") for path in self.lengths)
            yield (f"{module}: {count} sources, median {self.median_of(module):g} lines "
                   f"(at most {bound})")
        longest = max(self.lengths, key=self.lengths.get)
        yield f"longest source: {longest}, {self.lengths[longest]} lines (at most {MAX_LINES})"

    def check_mirror(self):
        """Each folder of tests/<module> with sources stands for a folder of the module."""
        tests = {os.path.dirname(path) for path, _ in files(self.root, *SOURCES, tops=("tests",))}
        for folder in sorted(tests):
            subject = folder.removeprefix("tests/")
            if subject.split("/")[0] not in MIRRORED or "fixtures" in subject.split("/"):
                continue
            if not (self.root / subject).is_dir():
                self.report(folder, f"mirrors nothing: there is no {subject}")
