#!/usr/bin/env python3
"""Does architecture.py see each kind of violation? Each is planted in a small tree of its own."""

import pathlib
import tempfile
import unittest

import architecture
import floors
import tree

SOUND = {
    "CMakeLists.txt": "add_subdirectory(core)\n",
    "README.md": "",
    ".gitignore": "/build/\n",
    "build/junk.cpp": '#include "server/app/server.h"\n',
    "proto/dcloc/v1/scan.proto": 'import "dcloc/v1/geometry.proto";\n'
                                 'import "google/protobuf/timestamp.proto";\n',
    "proto/dcloc/v1/geometry.proto": "",
    "core/geometry/pose.h": "#include <Eigen/Core>\n",
    "core/geometry/CMakeLists.txt": "dcloc_library(dcloc_geometry PUBLIC Eigen3::Eigen)\n",
    "core/radar/scan.h": '#include <chrono>\n#include "core/geometry/pose.h"\n'
                         "// not steady_clock, not std::thread\n",
    "core/map/radar_map.h": '#include "core/radar/scan.h"\n',
    "core/map/CMakeLists.txt": "dcloc_library(dcloc_map PUBLIC dcloc_radar)  # no dcloc_server\n",
    "server/maps/store/map_store.h": '#include "core/map/radar_map.h"\n',
    "server/maps/store/CMakeLists.txt": "dcloc_library(dcloc_server_maps_store PUBLIC dcloc_map)\n",
    "server/app/server.h": '#include <thread>\n#include "server/maps/store/map_store.h"\n'
                           '#include "dcloc/v1/scan.pb.h"\n',
    "server/app/CMakeLists.txt": "dcloc_library(dcloc_server PUBLIC dcloc_proto\n"
                                 "  PRIVATE dcloc_server_maps_store dcloc_options)\n"
                                 "add_executable(dcloc-server main.cpp)\n"
                                 "target_link_libraries(dcloc-server PRIVATE dcloc_server)\n",
    "client/sdk/session.h": '#include "dcloc/v1/scan.pb.h"\n',
    "client/datasets/drive.h": '#include "core/radar/scan.h"\n',
    "client/cli/map/map_command.h": '#include "client/sdk/session.h"\n',
    "client/cli/map/CMakeLists.txt": "dcloc_library(dcloc_cli_map PRIVATE dcloc_client)\n",
    "tests/client/cli/command_line_test.cpp": "",
    "client/cli/main.cpp": '#include "client/datasets/drive.h"\n'
                           '#include "client/cli/map/map_command.h"\n',
    "client/cli/CMakeLists.txt": "target_link_libraries(dcloc PRIVATE dcloc_cli_${room})\n",
    "tests/server/app/server_test.cpp": '#include "server/app/server.h"\n'
                                        '#include "client/sdk/session.h"\n',
    "tests/server/fixtures/test_server.h": '#include "server/app/server.h"\n',
    "tests/server/CMakeLists.txt": "add_library(dcloc_test_server test_server.cpp)\n"
                                   "dcloc_test(server_test LINK dcloc_test_server)\n",
}


def with_tests(planted):
    """With a test beside each source."""
    tests = {f"tests/{path.removesuffix('.cpp')}_test.cpp": "" for path in planted
             if path.endswith(".cpp") and not path.startswith(("tests/", "build/"))}
    return {**tests, **planted}


def violations(planted):
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        for path, text in {**SOUND, **planted}.items():
            file = root / path
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text)
        return architecture.violations(root)


class ArchitectureTest(unittest.TestCase):
    def expect_violation(self, path, text, message):
        self.expect_one(with_tests({path: text}), path, message)

    def expect_one(self, planted, path, message):
        found = violations(planted)
        self.assertEqual(len(found), 1, found)
        self.assertIn(path, found[0])
        self.assertIn(message, found[0])

    def expect_include_violation(self, path, header, message):
        self.expect_violation(path, f'#include "{header}"\n', message)


class TreeTest(ArchitectureTest):
    def test_a_sound_tree_is_fine(self):
        self.assertEqual(violations({}), [])

    def test_top_level_and_rooms_are_fixed(self):
        self.assertEqual(violations({"utils/x.txt": ""}),
                         ["utils: the top level has no place for it"])
        self.expect_violation("server.log", "", "top level")
        for path in ("core/helpers/a.h", "core/a.h", "core/map/detail/a.h", "server/utils/a.cpp",
                     "client/cli/misc/a.cpp"):
            self.expect_violation(path, "", "is no room")

    def test_no_file_is_too_long(self):
        for path in ("core/map/long.cpp", "client/cli/long.h", "tests/server/app/long_test.cpp"):
            self.assertEqual(violations(with_tests({path: "\n" * 400})), [])
            self.expect_violation(path, "\n" * 401, "has 401 lines; at most 400")

    def test_most_files_are_short(self):
        for folder, bound in (("core/map", 80), ("server/app", 110), ("client/cli", 110)):
            fit = {f"{folder}/long{i}.h": "\n" * bound for i in range(9)}
            self.assertEqual(violations(fit), [])
            self.expect_one({path: text + "\n" for path, text in fit.items()},
                            folder.split("/")[0] + ": ", f"a median of {bound + 1} lines")

    def test_tests_mirror_the_tree(self):
        for path in ("tests/core/helpers/a_test.cpp", "tests/server/maps/a_test.cpp",
                     "tests/client/cli/a_test.cpp"):
            self.assertEqual(violations({path: ""}), [] if "helpers" not in path else
                             ["tests/core/helpers: mirrors nothing: there is no core/helpers"])
        for path in ("tests/core/fixtures/a.h", "tests/benchmarks/a.cpp"):
            self.assertEqual(violations({path: ""}), [])

    def test_sources_have_a_test_beside(self):
        for room in ("core/map", "server/maps/store", "client/cli/map"):
            header, source, other = f"{room}/a.h", f"{room}/a.cpp", f"tests/{room}/b_test.cpp"
            self.expect_one({header: "", source: ""}, source, f"no test in tests/{room}")
            self.expect_one({header: "", source: "", other: ""}, source, f"no test in tests/{room}")
            for name in ("a_test.cpp", "a_test.py"):
                self.assertEqual(violations({source: "", f"tests/{room}/{name}": ""}), [])
            self.assertEqual(violations({header: "", source: "",
                                         other: f'#include "{header}"\n'}), [])

    def test_a_part_is_tested_with_what_uses_it(self):
        part = {"core/map/a.h": "", "core/map/a.cpp": '#include "core/map/a.h"\n'}
        user = {"core/map/b.h": "", "core/map/b.cpp": '#include "core/map/a.h"\n'}
        test = {"tests/core/map/b_test.cpp": ""}
        self.assertEqual(violations({**part, **user, **test}), [])
        self.assertEqual(len(violations({**part, **user})), 2)
        above = {"core/localizer/c.h": '#include "core/map/a.h"\n'}
        self.expect_one({**part, **user, **test, **above}, "core/map/a.cpp",
                        "no test in tests/core/map")

    def test_a_source_without_header_is_part_of_what_it_implements(self):
        source = {"core/map/a_more.cpp": '#include "core/map/a.h"\n', "core/map/a.h": ""}
        self.expect_one(source, "core/map/a_more.cpp", "no test")
        self.assertEqual(violations({**source, "tests/core/map/a_test.cpp": ""}), [])

    def test_what_is_tested_elsewhere_says_where(self):
        source, test = "core/map/map_content.cpp", "tests/core/map/map_file_test.cpp"
        self.assertEqual(violations({source: "", test: ""}), [])
        self.expect_one({source: "", "tests/core/map/b_test.cpp": ""}, source, "is not there")
        self.expect_one({source: "", test: "", "tests/core/map/map_content_test.cpp": ""}, source,
                        "is tested where it stands")


class IncludeTest(ArchitectureTest):
    def test_core_includes_nothing_of_ours(self):
        for header, room in [("server/app/server.h", "server/app"), ("dcloc/v1/scan.pb.h", "proto"),
                             ("client/datasets/drive.h", "client/datasets")]:
            self.expect_include_violation("core/radar/bad.cpp", header,
                                          f"core/radar may not use {room}")

    def test_core_knows_no_transport_log_thread_or_clock(self):
        for header in ["grpcpp/grpcpp.h", "google/protobuf/message.h", "spdlog/spdlog.h", "thread",
                       "mutex", "nlohmann/json.hpp"]:
            self.expect_violation("core/radar/bad.cpp", f"#include <{header}>\n", header)
        for code in ["auto t = std::chrono::steady_clock::now();", "std::jthread t;",
                     "std::random_device seed;", "clock_gettime(0, &t);"]:
            self.expect_violation("core/radar/bad.cpp", code, "core has no clock")

    def test_rooms_only_look_down(self):
        for path, header in [("core/geometry/bad.h", "core/radar/scan.h"),
                             ("core/map/bad.h", "core/registration/gicp.h"),
                             ("core/registration/bad.h", "core/localizer/localizer.h"),
                             ("server/base/bad.h", "server/net/health.h"),
                             ("server/maps/catalogue/bad.h", "server/maps/store/map_store.h"),
                             ("client/datasets/bad.h", "client/evaluation/metrics.h"),
                             ("client/simulation/world/bad.h", "client/simulation/simulation.h"),
                             ("client/cli/remote/bad.h", "client/cli/map/map_command.h"),
                             ("client/cli/server/bad.h", "client/cli/map/map_command.h")]:
            self.expect_include_violation(path, header, " may not use ")

    def test_sdk_is_thin(self):
        for header in ("core/radar/scan.h", "client/datasets/drive.h"):
            self.expect_include_violation("client/sdk/bad.h", header, "client/sdk may not use")

    def test_server_and_client_know_each_other_by_the_contract_only(self):
        self.expect_include_violation("server/net/bad.cpp", "client/sdk/session.h",
                                      "server/net may not use client/sdk")
        self.expect_violation("client/cli/bad.cpp", "#include <server/app/server.h>\n",
                              "client/cli may not use server")

    def test_nothing_uses_tests(self):
        self.expect_include_violation("client/cli/bad.cpp", "tests/server/fixtures/test_server.h",
                                      "client/cli may not use tests")

    def test_proto_imports_itself_only(self):
        self.expect_violation("proto/dcloc/v1/bad.proto", 'import "server/internal.proto";\n',
                              "proto may not use server/internal.proto")

    def test_folders_have_no_cycle(self):
        self.expect_one({"tests/client/sdk/a.h": '#include "tests/client/cli/a.h"\n',
                         "tests/client/cli/a.h": '#include "tests/client/sdk/b.h"\n',
                         "tests/client/sdk/b.h": ""},
                        "tests/client/cli", "folders use each other: tests/client/cli, tests/client/sdk")

    def test_files_have_no_cycle(self):
        self.expect_one({"core/map/a.h": '#include "core/map/b.h"\n',
                         "core/map/b.h": '#include "core/map/a.h"\n'},
                        "core/map/a.h", "files use each other: core/map/a.h, core/map/b.h")
        self.expect_one({"proto/dcloc/v1/geometry.proto": 'import "dcloc/v1/scan.proto";\n'},
                        "proto", "files use each other")

    def test_digests_have_one_place_on_each_side(self):
        code = "EVP_DigestInit_ex(context, EVP_sha256(), nullptr);\n"
        for path in ("client/sdk/sha256.cpp", "server/base/sha256.cpp", "tests/server/app/a.cpp"):
            self.assertEqual(violations(with_tests({path: code})), [])
        self.expect_violation("client/cli/map/hash.cpp", code, "digests are made in client/sdk")
        self.expect_violation("server/app/hash.cpp", "SHA256(data, size, out);\n", "digests")

    def test_includes_are_written_from_the_root(self):
        self.expect_include_violation("core/map/bad.cpp", "radar_map.h", "written from the root")


class LinkTest(ArchitectureTest):
    def test_libraries_link_as_headers_include(self):
        for room, library, used in [("core/submap", "dcloc_localizer", "core/localizer"),
                                    ("client/sdk", "dcloc_map", "core/map"),
                                    ("client/cli/common", "dcloc_cli_map", "client/cli/map"),
                                    ("server/base", "dcloc_server_maps_store", "server/maps/store")]:
            for call in (f"dcloc_library({floors.target_of(room)} PUBLIC {library})\n",
                         f"target_link_libraries({floors.target_of(room)} PRIVATE {library})\n"):
                self.expect_violation(f"{room}/CMakeLists.txt", call,
                                      f"{room} may not use {used} ({library})")

    def test_core_links_no_transport(self):
        self.expect_violation("core/submap/CMakeLists.txt",
                              "dcloc_library(dcloc_submap PRIVATE gRPC::grpc++)\n", "gRPC")

    def test_libraries_are_called_as_their_rooms(self):
        self.expect_violation("server/rpc/CMakeLists.txt", "add_library(dcloc_rpc INTERFACE)\n",
                              "dcloc_rpc is to be called dcloc_server_rpc")
        self.expect_violation("client/cli/CMakeLists.txt",
                              "target_link_libraries(dcloc PRIVATE dcloc_commands)\n",
                              "dcloc_commands is the library of no room")

    def test_no_target_is_too_large(self):
        for path, call in [("core/submap/CMakeLists.txt", "dcloc_library(dcloc_submap SOURCES"),
                           ("tests/core/CMakeLists.txt", "dcloc_test(core_test SOURCES")]:
            sources = " ".join(f"a{i}.cpp" for i in range(25))
            self.assertEqual(violations({path: f"{call} {sources})\n"}), [])
            self.expect_violation(path, f"{call} {sources} b.cpp)\n", "has 26 sources; at most 25")
            more = f"target_sources({call.split('(')[1].split()[0]} PRIVATE b.cpp)\n"
            self.expect_violation(path, f"{call} {sources})\n{more}", "has 26 sources; at most 25")


class CyclesTest(unittest.TestCase):
    def test_each_group_is_found_once(self):
        edges = {"a": {"b"}, "b": {"c", "x"}, "c": {"a"}, "x": {"y"}, "y": {"x"}, "z": {"a", "x"}}
        self.assertEqual(sorted(tree.cycles(edges)), [["a", "b", "c"], ["x", "y"]])
        self.assertEqual(tree.cycles({"a": {"b", "c"}, "b": {"c"}}), [])


if __name__ == "__main__":
    unittest.main()
