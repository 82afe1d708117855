#!/usr/bin/env python3
"""The image and the composition of containers are made of what is there.

Usage: image_test.py DCLOC SERVER [unittest arguments]
"""

import json
import os
import pathlib
import re
import shutil
import tempfile
import unittest

from deployed import (DEPLOY, PROGRAMS, check_server_arguments, load_yaml, main, needs_program,
                      needs_yaml, run, servers_of)


def dpkg_query(*arguments):
    return run("dpkg-query", *arguments).stdout.splitlines()


def libraries_of(program):
    """{library: Debian package} of what the program itself is linked with; ours are not there."""
    packages = {}
    linked = set(re.findall(r"NEEDED.*\[(.*)\]", run("readelf", "--dynamic", program).stdout))
    for line in run("ldd", program).stdout.splitlines():
        found = re.match(r"\s*(\S+) => (/\S+)", line)
        if found and found.group(1) in linked:
            # As it is found, or, since / and /usr are one, as the package names it.
            file = os.path.realpath(found.group(2))
            for name in (file, file.removeprefix("/usr")):
                owners = [owner for owner in dpkg_query("--search", name) if ": " in owner]
                if owners and not owners[0].startswith("dpkg-query:"):
                    packages[found.group(1)] = owners[0].split(":")[0]
                    break
    return packages


def closure(packages):
    """The packages with all that they depend on, as far as it is installed here."""
    depends, providers = {}, {}
    for line in dpkg_query("--show", "--showformat",
                           "${Package}\t${Provides}\t${Pre-Depends}, ${Depends}\n"):
        name, provides, needs = line.split("\t")
        depends[name] = re.split(r"[,|]", re.sub(r"\([^)]*\)|:any|\s", "", needs))
        for provided in re.sub(r"\([^)]*\)|\s", "", provides).split(","):
            providers.setdefault(provided, set()).add(name)
    found, new = set(), set(packages)
    while new:
        found |= new
        needed = {word for name in new for word in depends.get(name, []) if word}
        needed |= {name for word in needed for name in providers.get(word, ())}
        new = needed - found
    return found


class Compose(unittest.TestCase):
    @needs_yaml
    def test_compose_refers_to_what_is_there(self):
        (compose,) = load_yaml(DEPLOY / "compose.yml")
        made_by_user = {"./certs/dcloc.pem", "./certs/pgpass", "./certs/database-password"}
        services = compose["services"]
        for name, service in services.items():
            for volume in service.get("volumes", []):
                source = volume.split(":")[0]
                if source.startswith("./"):
                    self.assertTrue(source in made_by_user or (DEPLOY / source).exists(),
                                    f"{name}: {source}")
                else:
                    self.assertIn(source, compose["volumes"], name)
            for network in service["networks"]:
                self.assertIn(network, compose["networks"], name)
        check_server_arguments(self, services["dcloc-1"]["command"])
        for name in filter(lambda name: name.startswith("dcloc-"), services):
            entrypoint = services[name]["entrypoint"]
            check_server_arguments(self, entrypoint)
            known_as = entrypoint[entrypoint.index("--replica-address") + 1]
            self.assertEqual(known_as, name, "the others reach it by its name")
        for secret in compose["secrets"].values():
            self.assertIn(secret["file"], made_by_user)
        jobs = {job["job_name"]: job["static_configs"][0]["targets"] for job in load_yaml(
            DEPLOY / "monitoring/prometheus.yml")[0]["scrape_configs"]}
        servers = [name for name in services if name.startswith("dcloc-")]
        self.assertEqual(jobs["dcloc"], [f"{name}:9464" for name in servers])
        self.assertEqual(jobs["router"], ["router:8404"])
        self.assertEqual(servers_of((DEPLOY / "haproxy-replicas.cfg").read_text()),
                         [(name, name) for name in servers])

    @needs_program("docker-compose", "docker-compose")
    def test_compose_reads_its_file(self):
        result = run("docker-compose", "--file", DEPLOY / "compose.yml", "config", "--quiet")
        self.assertEqual(result.returncode, 0, result.stdout)


class Image(unittest.TestCase):
    def dockerfile(self):
        """Its instructions: (name, words)."""
        text = re.sub(r"^#.*\n", "", (DEPLOY / "Dockerfile").read_text(), flags=re.MULTILINE)
        lines = [line.split() for line in text.replace("\\\n", " ").splitlines() if line.strip()]
        return [(words[0], words[1:]) for words in lines]

    def test_the_image_has_every_library_that_the_programs_need(self):
        words = [word for name, words in self.dockerfile() if name == "RUN" for word in words]
        listed = words[words.index("--no-install-recommends") + 1:]
        installed = closure(listed[:listed.index("&&")])
        for program in PROGRAMS:
            for library, package in libraries_of(program).items():
                self.assertTrue(package in installed, f"{program} needs {library} of {package}")

    def test_the_image_is_made_of_what_is_there(self):
        instructions = self.dockerfile()
        known = {"FROM", "WORKDIR", "COPY", "RUN", "USER", "VOLUME", "EXPOSE", "STOPSIGNAL",
                 "ENTRYPOINT"}
        self.assertEqual({name for name, _ in instructions} - known, set())
        for name, words in instructions:
            if name == "COPY" and not words[0].startswith("--from"):
                for source in words[:-1]:
                    self.assertTrue((DEPLOY.parent / source).exists(), source)
        entrypoint = json.loads(" ".join(dict(instructions)["ENTRYPOINT"]))
        self.assertEqual(entrypoint[0], "dcloc-server")
        check_server_arguments(self, entrypoint)

    @needs_program("buildah", "buildah")
    @unittest.skipIf(os.geteuid() != 0, "needs root")
    def test_buildah_reads_the_dockerfile(self):
        """Each instruction is carried out, with programs that do nothing in the place of those that
        take long; tests/deploy/image builds the image as it is."""
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)

            def build(file, tag, context):
                return run("buildah", "--storage-driver", "vfs", "--root", folder / "storage",
                           "--runroot", folder / "run", "build", "--isolation", "chroot",
                           "--pull-never", "--file", file, "--tag", tag, context)

            def script(path, text="exit 0"):
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text(f"#!/bin/sh\n{text}\n")
                path.chmod(0o755)

            base = folder / "base"
            for library in re.findall(r"(/\S+) \(0x", run("ldd", "/bin/sh").stdout):
                copy = base / library.lstrip("/")
                copy.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy(library, copy)
            (base / "bin").mkdir()
            shutil.copy("/bin/sh", base / "bin")
            for program in ("apt-get", "install", "rm", "strip", "useradd"):
                script(base / "bin" / program)
            (folder / "Basefile").write_text("FROM scratch\nCOPY base /\n")
            made = build(folder / "Basefile", "docker.io/library/debian:bookworm-slim", folder)
            if made.returncode != 0:
                self.skipTest(f"buildah cannot work here: {made.stdout}")

            tree = folder / "tree"
            script(tree / "deploy/install-packages")
            (tree / "deploy/packages.txt").touch()
            script(tree / "deploy/build", "\n".join(
                f"echo >build/release/bin/{program}" for program in ("dcloc", "dcloc-server")))
            (tree / "build/release/bin").mkdir(parents=True)
            made = build(DEPLOY / "Dockerfile", "dcloc", tree)
            self.assertEqual(made.returncode, 0, made.stdout)
            text = (DEPLOY / "Dockerfile").read_text()
            for right, wrong in (("\nSTOPSIGNAL", "\nSTOPSIGNALS"), ("--from=build", "--form=build"),
                                 ("rm -rf", "(rm -rf"), (" AS build", " AS AS build")):
                self.assertIn(right, text)
                (folder / "Dockerfile").write_text(text.replace(right, wrong))
                broken = build(folder / "Dockerfile", "broken", tree)
                self.assertNotEqual(broken.returncode, 0, wrong)


if __name__ == "__main__":
    main()
