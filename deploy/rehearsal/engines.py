"""The engines that replicas share, each in a folder of its own: a database, and files of maps."""

import os
import pathlib
import pwd
import shutil
import signal

from rehearsal.programs import LOOPBACK, Failure, Program, free_port, run, wait_until

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
PACKAGES = {"database": ["postgresql-15", "postgresql-15-postgis-3"], "s3": ["python3-swift"],
            "router": ["haproxy"]}
_POSTGRES = pathlib.Path("/usr/lib/postgresql/15/bin")
_POSTGIS = pathlib.Path("/usr/share/postgresql/15/extension/postgis.control")
_DEBIAN_PYTHON = pathlib.Path("/usr/bin/python3")
_SWIFT = pathlib.Path("/usr/lib/python3/dist-packages/swift/common/middleware/s3api")
_SWIFT_SCRIPT = ROOT / "tests/server/fixtures/swift_service.py"


def missing_packages(files):
    """Debian's packages that are not installed."""
    there = {"database": (_POSTGRES / "postgres").exists() and _POSTGIS.exists(),
             "s3": files != "s3" or _SWIFT.exists(), "router": shutil.which("haproxy", path=PATH)}
    return [package for engine, packages in PACKAGES.items() if not there[engine]
            for package in packages]


PATH = os.environ.get("PATH", "") + ":/usr/sbin"


class Database:
    """PostgreSQL with PostGIS on a socket in its folder, and on no port. As root it runs as the user
    that Debian's package has made, since it refuses root."""

    name = "PostgreSQL"

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        self.folder.mkdir(mode=0o700)
        self.user = None
        if os.geteuid() == 0:
            self.user = "postgres"
            os.chown(self.folder, pwd.getpwnam(self.user).pw_uid, pwd.getpwnam(self.user).pw_gid)
        self.address = f"postgresql://dcloc@/dcloc?host={self.folder}"
        run(_POSTGRES / "initdb", "-D", self.folder / "data", "-U", "dcloc", "--auth=trust",
            "--no-sync", "--encoding=UTF8", "--locale=C", user=self.user, cwd=self.folder)
        self.start()
        run(_POSTGRES / "createdb", "-h", self.folder, "-U", "dcloc", "dcloc")
        self.query("CREATE EXTENSION postgis; CREATE EXTENSION pg_stat_statements")

    def start(self):
        # PostgreSQL ends fast, but tidily, on SIGINT.
        self.program = Program(
            self.name, [_POSTGRES / "postgres", "-D", self.folder / "data", "-k", self.folder,
                        "-h", "", "-F", "-c", "max_connections=100", "-c",
                        "shared_preload_libraries=pg_stat_statements"],
            self.folder / "log", user=self.user, end_signal=signal.SIGINT)
        wait_until(lambda: run(_POSTGRES / "pg_isready", "-h", self.folder,
                               check=False).returncode == 0, 60, "PostgreSQL")

    def stop(self):
        self.program.end()

    def _psql(self, *words, timeout_s=120):
        return run(_POSTGRES / "psql", "-h", self.folder, "-U", "dcloc", "-d", "dcloc", "-Atq", "-v",
                   "ON_ERROR_STOP=1", *words, timeout_s=timeout_s).stdout.strip()

    def query(self, sql):
        """What its rows have, a line each."""
        return self._psql("-c", sql).splitlines()

    def run_file(self, path, **variables):
        """Runs a file of psql with variables; what it prints."""
        given = [word for name, value in variables.items() for word in ("-v", f"{name}={value}")]
        return self._psql(*given, "-f", path, timeout_s=3600)

    def statement_count(self):
        """Statements since it was made, without those of this program."""
        return int(self.query("SELECT coalesce(sum(calls), 0) FROM pg_stat_statements"
                              " WHERE query NOT LIKE '%pg_stat_statements%'")[0])


class ObjectStore:
    """OpenStack Swift, which speaks S3."""

    name = "the object store"

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        self.folder.mkdir()
        self.port = free_port()
        keys = self.folder / "keys"
        keys.touch(mode=0o600)
        keys.write_text("aws_access_key_id = test:tester\naws_secret_access_key = testing\n",
                        encoding="utf-8")
        self.flags = ["--map-files", "s3://maps/fleet", "--object-endpoint",
                      f"http://{LOOPBACK}:{self.port}", "--object-credentials", keys]
        self.start()

    def start(self):
        output = self.folder / "log"
        seen = len(output.read_text(encoding="utf-8")) if output.exists() else 0
        self.program = Program(self.name, [_DEBIAN_PYTHON, _SWIFT_SCRIPT, self.folder, self.port],
                               output)

        def has_started():
            if not self.program.alive():
                raise Failure(f"{self.name} did not start: {self.program.text()[-2000:]}")
            return "listening on" in self.program.text()[seen:]

        wait_until(has_started, 60, self.name)

    def stop(self):
        self.program.kill()


class SharedFolder:
    """A folder that all replicas see. While it is away a file stands in its place, so that nothing can
    be opened or made there."""

    name = "the shared folder"
    program = None

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        self.folder.mkdir(mode=0o700)
        self.flags = ["--map-folder", self.folder]

    def start(self):
        self.folder.unlink()
        self.folder.with_suffix(".away").rename(self.folder)

    def stop(self):
        self.folder.rename(self.folder.with_suffix(".away"))
        self.folder.touch()
