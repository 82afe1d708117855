#!/usr/bin/env python3
"""Does architecture.py see each kind of violation? Each is planted in a small tree of its own."""

import pathlib
import tempfile
import unittest

import architecture

SOUND = {
    "CMakeLists.txt": "add_subdirectory(core)\n",
    "README.md": "",
    ".gitignore": "/build/\n",
    "build/junk.cpp": '#include "server/app/server.h"\n',
    "proto/dcloc/v1/scan.proto": 'import "dcloc/v1/geometry.proto";\n'
                                 'import "google/protobuf/timestamp.proto";\n',
    "core/geometry/pose.h": "#include <Eigen/Core>\n",
    "core/geometry/CMakeLists.txt": "dcloc_library(dcloc_geometry PUBLIC Eigen3::Eigen)\n",
    "core/radar/scan.h": '#include <chrono>\n#include "core/geometry/pose.h"\n'
                         "// not steady_clock, not std::thread\n",
    "core/map/radar_map.h": '#include "core/radar/scan.h"\n',
    "core/map/CMakeLists.txt": "dcloc_library(dcloc_map PUBLIC dcloc_radar)  # no dcloc_server\n",
    "server/app/server.h": '#include <thread>\n#include "core/map/radar_map.h"\n'
                       '#include "dcloc/v1/scan.pb.h"\n',
    "client/sdk/session.h": '#include "dcloc/v1/scan.pb.h"\n',
    "client/datasets/drive.h": '#include "core/radar/scan.h"\n',
    "client/cli/main.cpp": '#include "client/datasets/drive.h"\n#include "client/sdk/session.h"\n',
    "tests/server/server_test.cpp": '#include "server/app/server.h"\n#include "client/sdk/session.h"\n',
}


def violations(planted):
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        for path, text in {**SOUND, **planted}.items():
            file = root / path
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text)
        return architecture.Checker(root).run()


class ArchitectureTest(unittest.TestCase):
    def expect_violation(self, path, text, message):
        found = violations({path: text})
        self.assertEqual(len(found), 1, found)
        self.assertIn(path, found[0])
        self.assertIn(message, found[0])

    def test_a_sound_tree_is_fine(self):
        self.assertEqual(violations({}), [])

    def test_core_includes_nothing_of_ours(self):
        for header, module in [("server/app/server.h", "server"), ("dcloc/v1/scan.pb.h", "proto"),
                               ("client/datasets/drive.h", "client/datasets")]:
            self.expect_violation("core/radar/bad.cpp", f'#include "{header}"\n',
                                  f"core/radar may not use {module}")

    def test_core_knows_no_transport_log_thread_or_clock(self):
        for header in ["grpcpp/grpcpp.h", "google/protobuf/message.h", "spdlog/spdlog.h", "thread",
                       "mutex", "nlohmann/json.hpp"]:
            self.expect_violation("core/radar/bad.cpp", f"#include <{header}>\n", header)
        for code in ["auto t = std::chrono::steady_clock::now();", "std::jthread t;",
                     "std::random_device seed;", "clock_gettime(0, &t);"]:
            self.expect_violation("core/radar/bad.cpp", code, "core has no clock")

    def test_floors_of_core_only_look_down(self):
        for path, header in [("core/geometry/bad.h", "core/radar/scan.h"),
                             ("core/posegraph/bad.h", "core/radar/scan.h"),
                             ("core/map/bad.h", "core/registration/gicp.h"),
                             ("core/registration/bad.h", "core/localizer/localizer.h")]:
            self.expect_violation(path, f'#include "{header}"\n', "may not use core/")

    def test_sdk_is_thin(self):
        self.expect_violation("client/sdk/bad.h", '#include "core/radar/scan.h"\n',
                              "client/sdk may not use core/radar")
        self.expect_violation("client/sdk/bad.h", '#include "client/datasets/drive.h"\n',
                              "client/sdk may not use client/datasets")

    def test_server_and_client_know_each_other_by_the_contract_only(self):
        self.expect_violation("server/bad.cpp", '#include "client/sdk/session.h"\n',
                              "server may not use client/sdk")
        self.expect_violation("client/cli/bad.cpp", "#include <server/app/server.h>\n",
                              "client/cli may not use server")

    def test_nothing_uses_tests(self):
        self.expect_violation("client/cli/bad.cpp", '#include "tests/server/fixtures/test_server.h"\n',
                              "client/cli may not use tests")

    def test_proto_imports_itself_only(self):
        self.expect_violation("proto/dcloc/v1/bad.proto", 'import "server/internal.proto";\n',
                              "proto may not use server/internal.proto")

    def test_libraries_link_as_headers_include(self):
        self.expect_violation("core/submap/CMakeLists.txt",
                              "dcloc_library(dcloc_submap PUBLIC dcloc_localizer)\n",
                              "core/submap may not use core/localizer")
        self.expect_violation("client/sdk/CMakeLists.txt",
                              "target_link_libraries(dcloc_client PRIVATE dcloc_map)\n",
                              "client/sdk may not use core/map")
        self.expect_violation("core/submap/CMakeLists.txt",
                              "dcloc_library(dcloc_submap PRIVATE gRPC::grpc++)\n", "gRPC")

    def test_modules_have_no_cycle(self):
        found = violations({"client/datasets/bad.h": '#include "client/evaluation/metrics.h"\n',
                            "client/evaluation/bad.h": '#include "client/datasets/drive.h"\n'})
        self.assertEqual(len(found), 1, found)
        self.assertIn("modules use each other", found[0])

    def test_headers_have_no_cycle(self):
        found = violations({"core/map/a.h": '#include "core/map/b.h"\n',
                            "core/map/b.h": '#include "core/map/a.h"\n'})
        self.assertEqual(len(found), 1, found)
        self.assertIn("headers use each other", found[0])

    def test_includes_are_written_from_the_root(self):
        self.expect_violation("core/map/bad.cpp", '#include "radar_map.h"\n',
                              "written from the root")

    def test_top_level_and_modules_are_fixed(self):
        self.assertEqual(violations({"utils/x.txt": ""}),
                         ["utils: the top level has no place for it"])
        self.expect_violation("server.log", "", "top level")
        self.expect_violation("core/helpers/a.h", "", "belongs to no module")


if __name__ == "__main__":
    unittest.main()
