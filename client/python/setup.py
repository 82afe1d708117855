"""Makes the messages and stubs of dcloc/v1 from the protos beside this folder."""

import pathlib
import shutil
import subprocess

from setuptools import setup
from setuptools.command.build_py import build_py

PROTO = pathlib.Path(__file__).resolve().parent.parent.parent / "proto"


def generate(target):
    """Python, its type hints and the gRPC stubs, by the system's protoc (Debian packages
    protobuf-compiler, protobuf-compiler-grpc) or else by grpcio-tools."""
    protos = sorted(str(path.relative_to(PROTO)) for path in PROTO.glob("dcloc/v1/*.proto"))
    if not protos:
        raise FileNotFoundError(f"no protos in {PROTO}: install from a checkout")
    arguments = [f"--proto_path={PROTO}", f"--python_out={target}", f"--pyi_out={target}"]
    plugin = shutil.which("grpc_python_plugin")
    if shutil.which("protoc") and plugin:
        subprocess.run(["protoc", *arguments, f"--plugin=protoc-gen-grpc={plugin}",
                        f"--grpc_out={target}", *protos], check=True)
        return
    try:
        from grpc_tools import protoc
    except ImportError as error:
        raise FileNotFoundError("needs protoc and grpc_python_plugin, or grpcio-tools") from error
    if protoc.main(["protoc", *arguments, f"--grpc_python_out={target}", *protos]) != 0:
        raise RuntimeError("protoc failed")


class Build(build_py):
    def run(self):
        super().run()
        target = pathlib.Path(self.build_lib)
        (target / "dcloc/v1").mkdir(parents=True, exist_ok=True)
        generate(target)
        (target / "dcloc/v1/__init__.py").touch()


setup(cmdclass={"build_py": Build})
