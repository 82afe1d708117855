"""Who includes whom: rooms look down only, core knows no transport, clock or thread."""

import collections
import re

from floors import is_room, may_use, room_of
from tree import SOURCES, cycles, files

# What core may not know: transport, logging, threads and clocks.
CORE_FORBIDDEN_HEADER = re.compile(
    r"(grpc|google/protobuf/|spdlog/|prometheus/|nlohmann/|sqlite3)|"
    r"(thread|mutex|shared_mutex|future|condition_variable|semaphore|latch|barrier|stop_token|"
    r"pthread\.h|ctime|time\.h|sys/time\.h|iostream)$")
CORE_FORBIDDEN_CODE = re.compile(
    r"\w+_clock\b|\bclock_gettime\b|\bgettimeofday\b|\bstd::(?:j?thread|async)\b|\brandom_device\b|"
    r"\babsl::Now\b")

# SHA-256 is made in one place on each side of the wire; sdk and server share only the contract.
DIGEST = re.compile(r"\bEVP_(?:Digest|MD_CTX|Q_digest|sha256)\w*|\bSHA256\w*\(")
DIGEST_FILES = {"client/sdk/sha256.cpp", "server/base/sha256.cpp"}

INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^">]+)[>"]', re.MULTILINE)
IMPORT = re.compile(r'^\s*import\s+(?:public\s+|weak\s+)?"([^"]+)"', re.MULTILINE)
COMMENT_OR_TEXT = re.compile(r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"', re.DOTALL)


class IncludeCheck:
    def __init__(self, root, report):
        self.root = root
        self.report = report  # (path, text) of a violation
        self.room_edges = collections.defaultdict(set)  # {room: rooms that it includes as it may}
        self.file_edges = collections.defaultdict(set)  # {file: files of ours that it includes}
        self.cycle_counts = {}  # of folders and of files

    def run(self):
        for path, file in files(self.root, *SOURCES):
            self.check_source(path, file.read_text())
        for path, file in files(self.root, ".proto"):
            self.check_proto(path, file.read_text())
        for edges, what in ((self.room_edges, "folders"), (self.file_edges, "files")):
            found = cycles(edges)
            self.cycle_counts[what] = len(found)
            for cycle in found:
                self.report(cycle[0], f"{what} use each other: {', '.join(cycle)}")

    def figures(self):
        for what, count in self.cycle_counts.items():
            yield f"cycles of {what}: {count}"

    def check_source(self, path, text):
        room = room_of(path)
        if not is_room(room):
            self.report(path, "its folder is no room of floors.py")
        for quote, header in INCLUDE.findall(text):
            self.check_include(path, room, quote, header)
        if path not in DIGEST_FILES and not path.startswith("tests/") and DIGEST.search(text):
            self.report(path, "digests are made in " + " and ".join(sorted(DIGEST_FILES)))
        if path.startswith("core/"):
            for word in CORE_FORBIDDEN_CODE.findall(COMMENT_OR_TEXT.sub("", text)):
                self.report(path, f"core has no clock, no thread and no chance of its own ({word})")

    def check_include(self, path, room, quote, header):
        if path.startswith("core/") and CORE_FORBIDDEN_HEADER.match(header):
            self.report(path, f"core may not know <{header}>")
        is_file = (self.root / header).is_file()
        beside = (self.root / path).parent / header
        if quote == '"' and not is_file and beside.is_file():
            self.report(path, f'includes are written from the root ("{header}")')
        if is_file:
            self.file_edges[path].add(header)
        used = room_of(header)
        if used is None or used == room:
            return
        if not is_room(room):
            return
        if may_use(room, used):
            self.room_edges[room].add(used)
        else:
            self.report(path, f"{room} may not use {used} ({header})")

    def check_proto(self, path, text):
        for imported in IMPORT.findall(text):
            if not re.match(r"(dcloc/v\d+|google)/", imported):
                self.report(path, f"proto may not use {imported}")
            if (self.root / "proto" / imported).is_file():
                self.file_edges[path].add(f"proto/{imported}")
