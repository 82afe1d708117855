"""The floors of the house, stated once: which folder may use which."""

# Bottom up: a room uses only rooms of earlier lines. Rooms of one line do not use each other.
# Every folder with sources is a room.
FLOORS = {
    "core": [
        "options",
        "geometry",
        "radar",
        "odometry",
        "online_calibration submap",
        "posegraph",
        "map",
        "registration",
        "relocalization",
        "uncertainty",
        "calibration",
        "localizer mapping",
        "passes localizability",
        "update",
        "versions",
    ],
    "server": [
        "base",
        "postgres objects",
        "net",
        "telemetry",
        "config",
        "identity",
        "maps/catalogue",
        "maps/store",
        "convert",
        "passes",
        "maps/jobs",
        "tickets",
        "sessions",
        "rpc",
        "replicas",
        "maps/service",
        "localization",
        "admin",
        "app",
    ],
    "client": [
        "sdk/pose",
        "sdk",
        "sdk/c sdk/example",
        "trajectory rosbag",
        "datasets/files",
        "landmarks datasets",
        "datasets/check",
        "simulation/world",
        "simulation/motion",
        "simulation/radar",
        "simulation",
        "evaluation/baselines",
        "evaluation",
        "evaluation/paper",
        "evaluation/robustness",
        "evaluation/faults",
        "load",
        "cli/common",
        "cli/remote",
        "cli/calibrate cli/dataset cli/describe cli/doctor cli/evaluate cli/load cli/localize"
        " cli/map cli/map/server cli/plot cli/server cli/session cli/simulate",
        "cli",
        "ros",
        "ros/ros1",
    ],
}

# Which other modules a module uses.
MODULES = {
    "proto": (),
    "core": (),
    "server": ("core", "proto"),
    "client": ("core", "proto"),
    "tests": ("proto", "core", "server", "client"),
}

# What a vehicle links stays thin.
WITHOUT = {"client/sdk": ("core",), "client/sdk/pose": ("core",), "client/sdk/c": ("core",),
           "client/sdk/example": ("core",)}

FLOOR_OF = {f"{module}/{room}": index
            for module, floors in FLOORS.items()
            for index, floor in enumerate(floors)
            for room in floor.split()}

SPECIAL_TARGETS = {
    "proto": "dcloc_proto",
    "core/options": "dcloc_option_fields",  # dcloc_options are the compiler's
    "client/sdk": "dcloc_client",
    "server/app": "dcloc_server",
}


def target_of(room):
    """The name of the room's CMake library: dcloc_map, dcloc_server_maps_store, dcloc_cli_map."""
    if room in SPECIAL_TARGETS:
        return SPECIAL_TARGETS[room]
    module, _, rest = room.partition("/")
    return "dcloc_" + ("server_" if module == "server" else "") + rest.replace("/", "_")


ROOM_OF_TARGET = {target_of(room): room for room in (*FLOOR_OF, "proto")}


def module_of(path):
    """The module that a path relative to the tree belongs to; None where none."""
    top = path.split("/")[0]
    return top if top in MODULES else None


def room_of(path):
    """The room of a file, or of a header as it is included; None for what is not ours."""
    if path.startswith(("dcloc/v", "proto/")):
        return "proto"
    return path.rpartition("/")[0] if module_of(path) and "/" in path else None


def is_room(folder):
    """Whether the design has a place for sources in this folder."""
    return folder in FLOOR_OF or module_of(folder) in ("proto", "tests")


def may_use(user, used):
    """Whether a room may use another."""
    user_module, used_module = module_of(user), module_of(used)
    if user == used:
        return True
    if user_module != used_module:
        return used_module in MODULES[user_module] and used_module not in WITHOUT.get(user, ())
    if user_module not in FLOORS:
        return True
    return FLOOR_OF.get(used, len(FLOOR_OF)) < FLOOR_OF.get(user, 0)
