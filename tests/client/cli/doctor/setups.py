"""What `dcloc doctor` is tried on: servers, listeners that are none, bags that are read wrongly."""

import contextlib
import json
import math
import os
import pathlib
import socket
import ssl
import subprocess
import threading

from processes import Server

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent.parent.parent

FAKETIME = pathlib.Path("/usr/lib/x86_64-linux-gnu/faketime/libfaketimeMT.so.1")


def clock_off_by(seconds):
    """The environment of a program whose clock is another."""
    if not FAKETIME.exists():
        raise FileNotFoundError(f"{FAKETIME} is missing: install libfaketime")
    return {**os.environ, "LD_PRELOAD": str(FAKETIME), "FAKETIME": f"{seconds:+d}s",
            "FAKETIME_DONT_FAKE_MONOTONIC": "1"}


def certificates(folder, *arguments, environment=None):
    """The folder, with an authority and what deploy/certificates is asked to make."""
    subprocess.run([ROOT / "deploy/certificates", "--out", folder, *arguments], check=True,
                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=environment)
    return folder


class Listener:
    """A port on which something else than dcloc-server listens, `answer(socket)` once for each
    connection."""

    def __init__(self, answer):
        self._answer = answer
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.address = f"127.0.0.1:{self._listener.getsockname()[1]}"
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self):
        with contextlib.suppress(OSError):
            while True:
                connection = self._listener.accept()[0]
                threading.Thread(target=self._serve, args=(connection,), daemon=True).start()

    def _serve(self, connection):
        with contextlib.suppress(OSError), connection:
            self._answer(connection)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._listener.close()


def answer_http(connection):
    connection.recv(4096)
    connection.sendall(b"HTTP/1.1 400 Bad Request\r\nContent-Length: 0\r\n\r\n")


def answer_tls(folder, name):
    """Shakes hands with NAME's certificate, and waits for the other end."""
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.load_cert_chain(folder / f"{name}.pem", folder / f"{name}.key")
    context.set_alpn_protocols(["h2"])

    def answer(connection):
        with context.wrap_socket(connection, server_side=True) as stream:
            stream.recv(4096)
    return answer


class Sites:
    """Servers with a map "town" that is active and a map "asleep" that is not."""

    def __init__(self, programs, folder, map_file):
        self._programs, self._folder, self._map_file = programs, folder, map_file

    def open(self, name):
        """Nobody needs a token."""
        server = Server(self._programs, self._folder / name)
        self._upload(["--server", server.address])
        return server

    def guarded(self, name, *arguments, words=(), tokens=(), environment=None):
        """A token in NAME.WHO for each (WHO, role) of `tokens`, and for "ops"; `words` are what a
        client says to reach the server."""
        store = self._folder / name
        server = Server(self._programs, store, *arguments, environment=environment)
        for who, role in (("ops", "operator"), *tokens):
            self.token(store, who, role)
        self._upload(["--server", server.address, *words, "--token-file", f"{store}.ops"])
        return server

    def token(self, store, who, role, *arguments):
        made = subprocess.run([self._programs.server, "token", "create", "--data", store, "--name",
                               who, "--role", role, *arguments], check=True,
                              stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
        pathlib.Path(f"{store}.{who}").write_bytes(made.stdout)

    def _upload(self, words):
        self._programs.succeed("map", "upload", *words, "--map", "town", "--activate",
                               self._map_file)
        self._programs.succeed("map", "upload", *words, "--map", "asleep", self._map_file)


class Bag:
    """A bag of a drive, and how it is read; `planted` makes a folder where that is wrong."""

    def __init__(self, programs, folder, simulation, *radars):
        self._folder = folder
        self._folder.mkdir()
        programs.succeed("dataset", "export", "--dataset", "nuscenes", "--root", simulation,
                         "--drive", "live-0", "--radars", ",".join(radars), "--bag",
                         folder / "drive.bag", "--compression", "none")
        programs.succeed("dataset", "inspect", folder / "drive.bag", "--write-mapping",
                         folder / "dcloc_bag.json")
        self._count = 0

    def words(self, folder=None):
        return ["--dataset", "rosbag", "--root", folder or self._folder, "--drive", "drive"]

    def planted(self, mapping=None, rig=None):
        """`mapping(document)` and `rig(document)` change the files beside the bag."""
        self._count += 1
        folder = self._folder / str(self._count)
        folder.mkdir()
        (folder / "drive.bag").symlink_to(self._folder / "drive.bag")
        for name, change in (("dcloc_bag.json", mapping), ("dcloc_rig.json", rig)):
            document = json.loads((self._folder / name).read_text())
            if change is not None:
                change(document)
            (folder / name).write_text(json.dumps(document))
        return self.words(folder)


def with_bus(folder, simulation, change):
    """The simulation in FOLDER, whose bus says of live-0 what `change` makes of each sample."""
    folder.mkdir()
    for entry in simulation.iterdir():
        if entry.name != "can_bus":
            (folder / entry.name).symlink_to(entry)
    (folder / "can_bus").mkdir()
    for path in (simulation / "can_bus").iterdir():
        samples = json.loads(path.read_text())
        if path.name.startswith("live-0"):
            for sample in samples:
                change(sample)
        (folder / "can_bus" / path.name).write_text(json.dumps(samples))


def bus_times(speed=1.0, yaw_rate=1.0):
    def change(sample):
        sample["vel"] = [speed * value for value in sample["vel"]]
        sample["rotation_rate"] = [yaw_rate * value for value in sample["rotation_rate"]]
    return change


def bus_later_by(seconds):
    def change(sample):
        sample["utime"] += round(seconds * 1e6)
    return change


def set_of_first_radar(**fields):
    """A change of the first radar in a document."""
    return lambda document: document["radars"][0].update(fields)


def set_of_all_radars(**fields):
    return lambda document: [radar.update(fields) for radar in document["radars"]]


def front_mount(yaw_deg):
    """The mount of a simulated front radar, turned."""
    half = math.radians(yaw_deg) / 2
    return {"T_vehicle_radar": [3.41, 0.0, 0.5, math.cos(half), 0.0, 0.0, math.sin(half)]}


def swap_mounts(document):
    """The front radar where the left one sits, and the other way round."""
    half = math.radians(90) / 2
    front, left = document["radars"]
    front["T_vehicle_radar"] = [2.42, 0.8, 0.78, math.cos(half), 0.0, 0.0, math.sin(half)]
    left.update(front_mount(0))
