#!/usr/bin/env python3
"""Checks that the tree is built as it was designed: who may include and link whom.

Usage: architecture.py [ROOT]
Prints one line for each violation; the exit status is 1 if there is one.
"""

import os
import pathlib
import re
import sys

TOP_LEVEL = {"CMakeLists.txt", "CMakePresets.json", "README.md", "LICENSE", "CHANGELOG.md",
             "CONTRIBUTING.md", "proto", "server", "core", "client", "deploy", "tests", "maps"}
NOT_OURS = {"build", "compile_commands.json"}  # made here, and ignored by git

CORE_FLOORS = [["core/geometry"], ["core/radar", "core/posegraph"],
               ["core/submap", "core/calibration"], ["core/map"], ["core/registration"],
               ["core/localizer"]]
CORE = [module for floor in CORE_FLOORS for module in floor]
CLIENT = ["client/datasets", "client/simulation", "client/evaluation", "client/load", "client/cli"]


def allowed_modules():
    """{module: the other modules that it may use}"""
    allowed = {"proto": set(), "server": {"proto", *CORE}, "client/sdk": {"proto"}}
    for index, floor in enumerate(CORE_FLOORS):
        for module in floor:
            allowed[module] = {below for lower in CORE_FLOORS[:index] for below in lower}
    for module in CLIENT:
        allowed[module] = {"proto", "client/sdk", *CORE, *CLIENT} - {module}
    allowed["tests"] = set(allowed)
    return allowed


ALLOWED = allowed_modules()

# What core may not know: transport, logging, threads and clocks.
CORE_FORBIDDEN_HEADER = re.compile(
    r"(grpc|google/protobuf/|spdlog/|prometheus/|nlohmann/|sqlite3)|"
    r"(thread|mutex|shared_mutex|future|condition_variable|semaphore|latch|barrier|stop_token|"
    r"pthread\.h|ctime|time\.h|sys/time\.h|iostream)$")
CORE_FORBIDDEN_CODE = re.compile(
    r"\w+_clock\b|\bclock_gettime\b|\bgettimeofday\b|\bstd::(?:j?thread|async)\b|\brandom_device\b|"
    r"\babsl::Now\b")
CORE_FORBIDDEN_LINK = re.compile(r"\b(gRPC|protobuf|spdlog|Threads|prometheus-cpp)::")

INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]', re.MULTILINE)
IMPORT = re.compile(r'^\s*import\s+(?:public\s+|weak\s+)?"([^"]+)"', re.MULTILINE)
COMMENT_OR_TEXT = re.compile(r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"', re.DOTALL)
LINKED = re.compile(r"\bdcloc_\w+")
CMAKE_COMMENT = re.compile(r"#[^\n]*")
CMAKE_FUNCTIONS = {"dcloc_options", "dcloc_library", "dcloc_test", "dcloc_fuzz"}


def module_of(path):
    """The module that a path, relative to the tree, belongs to; None where none."""
    return next((module for module in sorted(ALLOWED, key=len, reverse=True)
                 if path.startswith(module + "/")), None)


def module_of_header(header):
    return "proto" if re.match(r"dcloc/v\d+/", header) else module_of(header)


def module_of_target(target):
    """The module that a CMake library of ours is built in; None for one that is unknown."""
    name = target.removeprefix("dcloc_")
    special = {"proto": "proto", "server": "server", "client": "client/sdk",
               "cli_server": "client/cli"}
    names = {module.split("/")[1]: module for module in [*CORE, *CLIENT]}
    return special.get(name) or names.get(name)


def files(root, *endings):
    for top in ("proto", "core", "server", "client", "tests"):
        for folder, _, names in os.walk(root / top):
            for name in sorted(names):
                if name.endswith(endings):
                    yield pathlib.Path(folder, name)


class Checker:
    def __init__(self, root):
        self.root = root
        self.violations = []
        self.module_edges = set()  # (from, to), the allowed ones
        self.header_edges = {}  # {file: files of ours that it includes}

    def report(self, path, text):
        self.violations.append(f"{path}: {text}")

    def use(self, path, module, what):
        """`path` uses `what`, which belongs to `module`."""
        own = module_of(path)
        if own is None or module is None or module == own:
            return
        if module in ALLOWED[own]:
            self.module_edges.add((own, module))
        else:
            self.report(path, f"{own} may not use {module} ({what})")

    def check_top_level(self):
        for entry in sorted(os.listdir(self.root)):
            if not entry.startswith(".") and entry not in TOP_LEVEL | NOT_OURS:
                self.report(entry, "the top level has no place for it")

    def check_source(self, file):
        path = str(file.relative_to(self.root))
        text = file.read_text()
        if module_of(path) is None:
            self.report(path, "belongs to no module")
        for quote, header in INCLUDE.findall(text):
            self.use(path, module_of_header(header), header)
            beside = file.parent / header
            if quote == '"' and not (self.root / header).is_file() and beside.is_file():
                self.report(path, f'includes are written from the root ("{header}")')
            if (self.root / header).is_file():
                self.header_edges.setdefault(path, []).append(header)
            if path.startswith("core/") and CORE_FORBIDDEN_HEADER.match(header):
                self.report(path, f"core may not know <{header}>")
        if path.startswith("core/"):
            for word in CORE_FORBIDDEN_CODE.findall(COMMENT_OR_TEXT.sub("", text)):
                self.report(path, f"core has no clock, no thread and no chance of its own ({word})")

    def check_proto(self, file):
        path = str(file.relative_to(self.root))
        for imported in IMPORT.findall(file.read_text()):
            if not re.match(r"(dcloc/v\d+|google)/", imported):
                self.report(path, f"proto may not use {imported}")

    def check_cmake(self, file):
        path = str(file.relative_to(self.root))
        text = CMAKE_COMMENT.sub("", file.read_text())
        for target in sorted(set(LINKED.findall(text)) - CMAKE_FUNCTIONS):
            self.use(path, module_of_target(target), target)
        if path.startswith("core/"):
            for library in sorted(set(CORE_FORBIDDEN_LINK.findall(text))):
                self.report(path, f"core may not link {library}")

    def check_cycles(self):
        modules = {}
        for source, target in self.module_edges:
            modules.setdefault(source, []).append(target)
        for edges, what in ((modules, "modules"), (self.header_edges, "headers")):
            cycle = find_cycle(edges)
            if cycle:
                self.report(cycle[0], f"{what} use each other: {' -> '.join(cycle)}")

    def run(self):
        self.check_top_level()
        for file in files(self.root, ".h", ".hpp", ".cpp", ".cc"):
            self.check_source(file)
        for file in files(self.root, ".proto"):
            self.check_proto(file)
        for file in files(self.root, "CMakeLists.txt"):
            self.check_cmake(file)
        self.check_cycles()
        return self.violations


def find_cycle(edges):
    """The nodes of one cycle, its first repeated at the end; None if there is none."""
    done, path = set(), []

    def visit(node):
        if node in path:
            return path[path.index(node):] + [node]
        if node in done:
            return None
        path.append(node)
        for target in sorted(edges.get(node, [])):
            cycle = visit(target)
            if cycle:
                return cycle
        path.pop()
        done.add(node)
        return None

    return next(filter(None, map(visit, sorted(edges))), None)


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else
                        pathlib.Path(__file__).parent.parent.parent).resolve()
    checker = Checker(root)
    for violation in checker.run():
        print(violation)
    print(f"{len(checker.module_edges)} edges between modules, "
          f"{len(checker.violations)} violations")
    return 1 if checker.violations else 0


if __name__ == "__main__":
    sys.exit(main())
