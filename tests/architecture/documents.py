#!/usr/bin/env python3
"""Checks the documents: their length, and that links, names and cited equations exist; that each
decision stands in its index.

Usage: documents.py [ROOT]
Prints FILE:LINE: and what is wrong, one line for each violation; the exit status is 1 if there is
one.
"""

import os
import pathlib
import re
import sys

sys.dont_write_bytecode = True  # the tree stays as it is

from index_check import check_indexes  # noqa: E402

MAX_README_LINES = 130
MAX_FOLDER_README_LINES = 80
MAX_DECISION_LINES = 40
MAX_PARAGRAPH_WORDS = 90

METHOD = "core/METHOD.md"
FIRST_OWN_EQUATION = 20  # those before it have the paper's numbers, each row in its own order
NOT_OURS = {"build", "node_modules"}
SOURCES = (".h", ".cpp", ".proto", ".py")
OWN = {"tests/architecture/documents.py", "tests/architecture/documents_test.py"}

NUMBERS = r"(\d+(?:\s*-\s*\d+)?(?:,\s*\d+(?:\s*-\s*\d+)?)*)"
CITED_EQUATION = re.compile(r"\beqs?\.?[\s/#*]+" + NUMBERS)
CITED_SECTION = re.compile(r"\bMETHOD[\s/#*]+(?:section[\s/#*]+)?" + NUMBERS)
COMMENT = re.compile(r'//[^\n]*|/\*.*?\*/|#[^\n]*|"""(?:.*?)"""', re.DOTALL)
STRING = re.compile(r'"(?:\\.|[^"\\\n])*"')
FENCED = re.compile(r"^ *```.*?^ *```", re.DOTALL | re.MULTILINE)
EQUATION_TAG = re.compile(r"\((\d+)\)\s*$", re.MULTILINE)
EQUATION_IN_PROSE = re.compile(r"\((\d{1,2})\)")
SECTION_TAG = re.compile(r"^##+\s+(\d+)\.", re.MULTILINE)
LINK = re.compile(r"\]\(([^)\s]+)\)")
INLINE_CODE = re.compile(r"`([^`\n]+)`")
OUR_PATH = re.compile(r"(?:core|server|client|tests|deploy|proto|maps)/[\w./-]+")
PLACEHOLDER = re.compile(r"(^|/)[A-Z]+(/|$)")  # as in core/ROOM/
OUR_NAME = re.compile(r"[A-Z][a-z0-9]+(?:[A-Z][a-z0-9]*)+")
HEADING = re.compile(r"^#+\s+(.*?)\s*$", re.MULTILINE)
ITEM = re.compile(r"\s*(?:[-*+]|\d+\.)\s+")


def numbers_in(text):
    """The numbers of "1-3, 7"."""
    numbers = set()
    for part in text.split(","):
        ends = [int(end) for end in re.findall(r"\d+", part)]
        numbers.update(range(ends[0], ends[-1] + 1))
    return numbers


def line_of(text, position):
    return text.count("\n", 0, position) + 1


def without_code(text):
    """The text with its fenced blocks and inline code blanked; lines keep their numbers."""
    text = FENCED.sub(lambda m: "\n" * m.group().count("\n"), text)
    return re.sub(r"`[^`\n]*`", "x", text)


def paragraphs(text):
    """Yields (line, words) of each paragraph and each list item; tables and headings are none."""
    begin, words = 0, 0
    for number, line in enumerate(without_code(text).splitlines() + [""], 1):
        is_other = not line.strip() or line.lstrip().startswith(("|", "#"))
        if (is_other or ITEM.match(line)) and words:
            yield begin, words
            words = 0
        if is_other:
            continue
        if not words:
            begin = number
        words += len(ITEM.sub("", line, count=1).split())


def is_record(path):
    """Whether a document tells of its time, so that what it names may have gone."""
    return "/decisions/" in path or path == "CHANGELOG.md"


def anchors(text):
    """The names under which a document's headings can be linked."""
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")
            for heading in HEADING.findall(text)}


class Checker:
    def __init__(self, root):
        self.root = pathlib.Path(root)
        self.violations = []
        self.equations, self.sections = set(), set()

    def report(self, path, line, text):
        self.violations.append(f"{path}:{line}: {text}")

    def files(self, *endings):
        for folder, folders, names in os.walk(self.root):
            folders[:] = sorted(f for f in folders if f not in NOT_OURS and not f.startswith("."))
            for name in sorted(names):
                if name.endswith(endings):
                    path = pathlib.Path(folder, name)
                    yield str(path.relative_to(self.root)), path.read_text(errors="replace")

    def read_method(self):
        method = self.root / METHOD
        if not method.is_file():
            self.report(METHOD, 1, "is not there")
            return
        text = method.read_text()
        self.sections = {int(n) for n in SECTION_TAG.findall(text)}
        last = {False: 0, True: 0}  # of the paper's and of our equations
        for block in FENCED.finditer(text):
            for tag in EQUATION_TAG.finditer(block.group()):
                number = int(tag.group(1))
                line = line_of(text, block.start() + tag.start())
                if number in self.equations:
                    self.report(METHOD, line, f"equation {number} stands here again")
                elif (before := last[number >= FIRST_OWN_EQUATION]) > number:
                    self.report(METHOD, line, f"equation {number} stands after {before}")
                last[number >= FIRST_OWN_EQUATION] = number
                self.equations.add(number)
        prose = without_code(text)
        for match in EQUATION_IN_PROSE.finditer(prose):
            if int(match.group(1)) not in self.equations:
                self.report(METHOD, line_of(prose, match.start()),
                            f"there is no equation {match.group(1)}")

    def check_citations(self, path, text, offset=0, whole=None):
        whole = text if whole is None else whole
        for pattern, known, kind in ((CITED_EQUATION, self.equations, "equation"),
                                     (CITED_SECTION, self.sections, "section")):
            for match in pattern.finditer(text):
                for number in sorted(numbers_in(match.group(1)) - known):
                    self.report(path, line_of(whole, offset + match.start()),
                                f"{METHOD} has no {kind} {number}")

    def check_source(self, path, text):
        blanked = text
        if not path.endswith(".py"):
            blanked = STRING.sub(lambda m: " " * len(m.group()), text)
        # Comments that follow one another are read as one, for a citation may be broken.
        comments = "".join(
            c if inside else re.sub(r"[^\n]", " ", c) for c, inside in split_comments(blanked))
        self.check_citations(path, comments)

    def check_length(self, path, text):
        name = path.rsplit("/", 1)[-1]
        limit = None
        if path == "README.md":
            limit = MAX_README_LINES
        elif path.endswith("/decisions/README.md"):
            limit = None  # one line a record
        elif name == "README.md":
            limit = MAX_FOLDER_README_LINES
        elif "/decisions/" in path:
            limit = MAX_DECISION_LINES
        count = len(text.splitlines())
        if limit is not None and count > limit:
            self.report(path, limit + 1, f"{count} lines, {limit} at most")

    def check_paragraphs(self, path, text):
        for line, words in paragraphs(text):
            if words > MAX_PARAGRAPH_WORDS:
                self.report(path, line,
                            f"a paragraph of {words} words, {MAX_PARAGRAPH_WORDS} at most")

    def check_links(self, path, text):
        blanked = without_code(text)
        for match in LINK.finditer(blanked):
            target, _, anchor = match.group(1).partition("#")
            if re.match(r"\w+:", target):
                continue
            line = line_of(blanked, match.start())
            file = (self.root / path).parent / target if target else self.root / path
            if not file.exists():
                self.report(path, line, f"nothing is at {match.group(1)}")
            elif anchor and file.suffix == ".md" and anchor not in anchors(file.read_text()):
                self.report(path, line, f"no heading is called {match.group(1)}")

    def has_path(self, document, pattern):
        """Whether there is one, seen from the root or from a folder that the document lies in."""
        return any(any((self.root / folder).glob(pattern))
                   for folder in pathlib.PurePosixPath(document).parents)

    def check_names(self, path, text, words):
        """Paths and names of ours that are set as code must be those of the tree."""
        blanked = FENCED.sub(lambda m: "\n" * m.group().count("\n"), text)
        for match in INLINE_CODE.finditer(blanked):
            code, line = match.group(1), line_of(blanked, match.start())
            if OUR_PATH.fullmatch(code) and not PLACEHOLDER.search(code):
                if not self.has_path(path, code.rstrip("/") + "*"):
                    self.report(path, line, f"nothing is called {code}")
            is_cut = code.endswith("...")
            for name in re.split(r"::|\.", re.sub(r"\(\)$", "", code)):
                if not OUR_NAME.fullmatch(name) or name in words:
                    continue
                if not (is_cut and any(word.startswith(name) for word in words)):
                    self.report(path, line, f"no source knows {name}")

    def run(self):
        self.read_method()
        words = set()
        for _, text in self.files(*SOURCES, ".txt", ".yml", ".json", ".service", ".in"):
            words.update(re.findall(r"[A-Z]\w+", text))
        for path, text in self.files(".md"):
            self.check_length(path, text)
            self.check_paragraphs(path, text)
            self.check_links(path, text)
            self.check_citations(path, without_code(text))
            if not is_record(path):
                self.check_names(path, text, words)
        check_indexes(self.root, self.report)
        for path, text in self.files(*SOURCES):
            if path not in OWN:
                self.check_source(path, text)
        return self.violations


def split_comments(text):
    """Yields (piece, whether it is a comment), all of the text in order."""
    end = 0
    for match in COMMENT.finditer(text):
        yield text[end:match.start()], False
        yield match.group(), True
        end = match.end()
    yield text[end:], False


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else
                        pathlib.Path(__file__).parent.parent.parent).resolve()
    violations = Checker(root).run()
    for violation in violations:
        print(violation)
    print(f"{len(violations)} violations")
    return 1 if violations else 0


if __name__ == "__main__":
    sys.exit(main())
