"""What CMake says: a library for each room, linked as the floors allow, of a size to understand."""

import collections
import re

from floors import ROOM_OF_TARGET, FLOOR_OF, may_use, module_of, room_of, target_of
from tree import files

MAX_SOURCES = 25

COMMENT = re.compile(r"#[^\n]*")
COMMAND = re.compile(r"\b(\w+)\s*\(([^()]*)\)")
OURS = re.compile(r"\bdcloc_\w+\b(?!\$)")
SOURCE = re.compile(r"\S+\.(?:cpp|cc|c)$")
LIBRARIES = {"dcloc_library", "add_library"}
TARGETS = {*LIBRARIES, "add_executable", "dcloc_test", "dcloc_fuzz"}
NOT_A_ROOM = {"dcloc_options"}
CORE_FORBIDDEN = re.compile(r"\b(gRPC|protobuf|spdlog|Threads|prometheus-cpp)::")


class LinkCheck:
    def __init__(self, root, report):
        self.root = root
        self.report = report  # (path, text) of a violation
        self.source_counts = collections.Counter()  # by target

    def run(self):
        for path, file in files(self.root, "CMakeLists.txt"):
            text = COMMENT.sub("", file.read_text())
            for command, arguments in COMMAND.findall(text):
                words = arguments.split()
                if command in TARGETS and words:
                    self.check_name(path, command, words[0])
                if command in TARGETS | {"target_sources"} and words:
                    self.check_size(path, words)
                if command in TARGETS | {"target_link_libraries"} and module_of(path) != "tests":
                    self.check_links(path, words[1:])
            if path.startswith("core/"):
                for library in sorted(set(CORE_FORBIDDEN.findall(text))):
                    self.report(path, f"core may not link {library}")

    def figures(self):
        name, count = self.source_counts.most_common(1)[0]
        yield (f"{len(self.source_counts)} targets, the largest {name} with {count} sources "
               f"(at most {MAX_SOURCES})")

    def check_name(self, path, command, name):
        room = room_of(path)
        if command in LIBRARIES and room in FLOOR_OF and "$" not in name:
            if name != target_of(room):
                self.report(path, f"{name} is to be called {target_of(room)}")

    def check_size(self, path, words):
        name, before = words[0], self.source_counts[words[0]]
        self.source_counts[name] += sum(1 for word in words[1:] if SOURCE.match(word))
        count = self.source_counts[name]
        if "$" not in name and before <= MAX_SOURCES < count:
            self.report(path, f"{name} has {count} sources; at most {MAX_SOURCES}")

    def check_links(self, path, words):
        room = room_of(path)
        for target in sorted(set(OURS.findall(" ".join(words))) - NOT_A_ROOM):
            used = ROOM_OF_TARGET.get(target)
            if used is None:
                self.report(path, f"{target} is the library of no room of floors.py")
            elif not may_use(room, used):
                self.report(path, f"{room} may not use {used} ({target})")
