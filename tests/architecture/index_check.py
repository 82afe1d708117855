"""Each decision stands once in the README.md beside it, in a line of its own that can be read."""

import re

MAX_LINE = 120
RECORD = re.compile(r"\d{4}-[\w-]+\.md")
ENTRY = re.compile(r"- \[(\d{4})\]\((\1-[\w-]+\.md)\) \S")


def check_indexes(root, report):
    """Calls `report(path, line, text)` for each fault of an index."""
    for folder in sorted(root.glob("*/decisions")):
        check_index(folder, str((folder / "README.md").relative_to(root)), report)


def check_index(folder, path, report):
    listed = {}
    readme = folder / "README.md"
    lines = readme.read_text().splitlines() if readme.is_file() else []
    for number, line in enumerate(lines, 1):
        if not RECORD.search(line):
            continue
        entry = ENTRY.match(line)
        if not entry or len(RECORD.findall(line)) > 1:
            report(path, number, "a record's line is: - [NNNN](NNNN-title.md) What was decided")
            continue
        if len(line) > MAX_LINE:
            report(path, number, f"a line of {len(line)} characters, {MAX_LINE} at most")
        if entry.group(2) in listed:
            report(path, number, f"{entry.group(2)} stands in line {listed[entry.group(2)]}, too")
        listed[entry.group(2)] = number
    for record in sorted(folder.iterdir()):
        if RECORD.fullmatch(record.name) and record.name not in listed:
            report(path, 1, f"has no line for {record.name}")
