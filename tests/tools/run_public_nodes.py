"""Runs the public rclpy examples plain and under `rosslt_auto run`, and compares what they print.

    python tests/tools/run_public_nodes.py FOLDER [--seconds S] [--only PATTERN] [--path FOLDER]...

FOLDER holds unmodified checkouts of the repositories ros2/examples and ros2/demos, under any names,
of the branch that belongs to the installed rclpy (jazzy).
Every Python publisher, subscriber, service, client, parameter and lifecycle program in them is
run; programs of which PROGRAMS below says nothing are found too, and run without a partner.
Partners (the talker for a listener, say) are always plain, so that one thing varies at a time.

A program that does not end by itself is interrupted after S seconds, as with Ctrl-C; where the
plain one ends by itself, the instrumented one has as long as it takes. Then exit status, stdout and
stderr are compared line by line, without time stamps:

    same         all lines are equal, up to the end of the shorter output
    same, later  equal from the first line that both have, as the programs were started at
                 different times
    same kinds   the same lines when numbers are ignored (for what is measured or counted)
    other order  the same kinds of lines, in another order (for what waits for the network)
    DIFFERENT    with the first line that differs. A busy machine may have found a partner too late
                 or have cut a program off too early: try again with more seconds.
    (fails)      behind one of these: the plain program ends with a traceback too
    needs X      the plain program cannot import X, so there is nothing to compare

Exit status 1 if anything is different. `--path` adds a folder to PYTHONPATH, for packages that
the environment does not have.
"""

import argparse
import ast
import itertools
import os
import re
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from fnmatch import fnmatch
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from support.domains import reserved_domain
from support.output import normalised
from support.process import Outcome, Program, environment, start
from support.waiting import DEADLINE, DeadlineMissed

BLACKBOARD = """
import rclpy
rclpy.init()
rclpy.spin(rclpy.create_node("parameter_blackboard", allow_undeclared_parameters=True))
"""

SET_PARAMETERS = """
import rclpy
from rclpy.parameter import Parameter
from rclpy.parameter_client import AsyncParameterClient
rclpy.init()
node = rclpy.create_node("setter")
client = AsyncParameterClient(node, "set_parameters_callback")
client.wait_for_services(20.0)
for value in (1.5, 2.5, "x"):
    future = client.set_parameters([Parameter("param1", value=value)])
    rclpy.spin_until_future_complete(node, future)
"""

TRANSITIONS = """
import rclpy
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
rclpy.init()
node = rclpy.create_node("manager")
client = node.create_client(ChangeState, "lc_talker/change_state")
client.wait_for_service(20.0)
for transition in (Transition.TRANSITION_CONFIGURE, Transition.TRANSITION_ACTIVATE):
    request = ChangeState.Request(transition=Transition(id=transition))
    rclpy.spin_until_future_complete(node, client.call_async(request))
"""


@dataclass(frozen=True)
class How:
    """How a program is run. Partners: paths of programs, or code; each may have arguments."""

    arguments: Sequence[str] = ()
    partners: Sequence[str] = ()
    seconds: float | None = None  # None: as on the command line


_SERVICE = "minimal_service/examples_rclpy_minimal_service/service.py"
_CLIENT = "minimal_client/examples_rclpy_minimal_client/client.py"
_PUBLISHER = "minimal_publisher/examples_rclpy_minimal_publisher/publisher_member_function.py"
_SUBSCRIBER = "minimal_subscriber/examples_rclpy_minimal_subscriber/subscriber_lambda.py"
_QOS = "quality_of_service_demo_py/"

# By the end of the path, without a variant after a `#`.
PROGRAMS: dict[str, How] = {
    "subscriber_lambda.py": How(partners=[_PUBLISHER]),
    "subscriber_member_function.py": How(partners=[_PUBLISHER]),
    "subscriber_old_school.py": How(partners=[_PUBLISHER]),
    "publisher_member_function.py": How(partners=[_SUBSCRIBER]),
    "minimal_client/client.py": How(partners=[_SERVICE]),
    "client.py": How(partners=[_SERVICE]),
    "client_async.py": How(partners=[_SERVICE]),
    "client_async_callback.py": How(partners=[_SERVICE]),
    "client_async_member_function.py": How(partners=[_SERVICE]),
    "minimal_service/service.py": How(partners=[_CLIENT]),
    "service.py": How(partners=[_CLIENT]),
    "service_member_function.py": How(partners=[_CLIENT]),
    "examples_rclpy_executors/listener.py": How(partners=["examples_rclpy_executors/talker.py"]),
    "custom_callback_group.py": How(partners=["examples_rclpy_executors/listener.py"]),
    "topics/listener.py": How(partners=["demo_nodes_py/topics/talker.py"]),
    "topics/listener_serialized.py": How(partners=["demo_nodes_py/topics/talker.py"]),
    "topics/talker_qos.py": How(["-n", "3", "--reliable"]),
    "topics/talker_qos.py#best-effort": How(["-n", "3"]),
    "topics/listener_qos.py": How(["-n", "3"], ["demo_nodes_py/topics/talker_qos.py"]),
    "topics/listener_qos.py#reliable": How(
        ["-n", "3", "--reliable"], ["demo_nodes_py/topics/talker_qos.py --reliable"]
    ),
    "add_two_ints_client.py": How(partners=["demo_nodes_py/services/add_two_ints_server.py"]),
    "add_two_ints_client_async.py": How(partners=["demo_nodes_py/services/add_two_ints_server.py"]),
    "add_two_ints_server.py": How(partners=["demo_nodes_py/services/add_two_ints_client.py"]),
    "async_param_client.py": How(partners=[BLACKBOARD]),
    "set_parameters_callback.py": How(partners=[SET_PARAMETERS]),
    "use_logger_service.py": How(seconds=12),
    "matched_event_detect.py": How(seconds=15),
    "lifecycle_py/talker.py": How(partners=[TRANSITIONS]),
    _QOS + "deadline.py": How(["600", "--publish-for", "1500", "--pause-for", "1500"]),
    _QOS + "incompatible_qos.py": How(["durability"]),
    _QOS + "incompatible_qos.py#reliability": How(["reliability"]),
    _QOS + "lifespan.py": How(["1000", "--publish-count", "4", "--subscribe-after", "2500"]),
    _QOS + "liveliness.py": How(["250", "--kill-publisher-after", "2000"], seconds=5),
    _QOS + "liveliness.py#manual": How(
        ["250", "--policy", "MANUAL_BY_TOPIC", "--kill-publisher-after", "2000"], seconds=5
    ),
    _QOS + "qos_overrides_listener.py": How(partners=[_QOS + "qos_overrides_talker.py"]),
    _QOS + "qos_overrides_talker.py": How(),
    "scripts/data_publisher.py": How(["--end-after", "3"]),
    "scripts/topic_monitor.py": How(partners=["topic_monitor/scripts/data_publisher.py"]),
}

# Not programs of their own.
_IGNORED = ("setup.py", "__init__.py", "common_nodes.py", "*launch.py")
_IGNORED_FOLDERS = {"test", "tests", "launch", "launch_testing", "rclcpp"}


@dataclass
class Result:
    program: str
    plain: str = ""
    instrumented: str = ""
    difference: str = ""
    details: list[str] = field(default_factory=list)


class Checkout:
    """The folder with the repositories."""

    def __init__(self, folder: Path, extra: Sequence[str]) -> None:
        self.folder = folder
        self._files = [
            file
            for file in sorted(folder.rglob("*.py"))
            if not _IGNORED_FOLDERS & set(file.relative_to(folder).parts[:-1])
        ]
        packages = {file.parent for file in self._files if file.name == "__init__.py"}
        roots = {package.parent for package in packages if package.parent not in packages}
        inherited = os.environ.get("PYTHONPATH")
        self.python_path = os.pathsep.join(
            [*extra, *map(str, sorted(roots)), *([inherited] if inherited else [])]
        )

    def programs(self) -> list[Path]:
        """The files that use rclpy and can be run."""
        return [
            file
            for file in self._files
            if not any(fnmatch(file.name, pattern) for pattern in _IGNORED)
            and "rclpy" in (text := file.read_text())
            and re.search(r"^if __name__ ==", text, re.MULTILINE)
        ]

    def find(self, end: str) -> Path:
        """The program whose path ends so."""
        [file] = [file for file in self._files if str(file).endswith("/" + end)]
        return file

    def share(self, prefix: Path) -> None:
        """Makes below `prefix` what an installed package has and the programs ask for."""
        index = prefix / "share" / "ament_index" / "resource_index" / "packages"
        index.mkdir(parents=True)
        for file in self.folder.rglob("params.yaml"):
            package = "demo_nodes_py"
            (index / package).touch()
            (prefix / "share" / package).mkdir(exist_ok=True)
            (prefix / "share" / package / file.name).write_text(file.read_text())


def missing_modules(file: Path, program: Outcome) -> list[str]:
    """What the program could not import, and what else of that kind it would ask for."""
    if "ModuleNotFoundError" not in program.stderr:
        return []
    found = set(re.findall(r"No module named '([\w.]+)'", program.stderr))
    imported = {
        node.module.split(".")[0]
        for node in ast.walk(ast.parse(file.read_text()))
        if isinstance(node, ast.ImportFrom) and node.module
    }
    return sorted({name.split(".")[0] for name in found} | (imported & {"example_interfaces"}))


def run(
    checkout: Checkout, file: Path, how: How, prefix: Path, seconds: float, instrumented: bool
) -> tuple[Outcome, bool]:
    """Runs a program beside its partners until it ends or its time is over; whether it ended."""
    with ExitStack() as stack:
        domain = stack.enter_context(reserved_domain())
        variables = {
            "PYTHONPATH": checkout.python_path,
            "ROS_LOG_DIR": str(prefix / "log"),
            "AMENT_PREFIX_PATH": os.pathsep.join(
                filter(None, [str(prefix), os.environ.get("AMENT_PREFIX_PATH")])
            ),
        }
        for partner in how.partners:
            command = (
                ["-c", partner]
                if "import" in partner
                else [str(checkout.find(partner.split()[0])), *partner.split()[1:]]
            )
            stack.enter_context(
                Program([sys.executable, *command], environment(domain, **variables))
            )
        program = stack.enter_context(
            start(file, *how.arguments, domain=domain, instrumented=instrumented, **variables)
        )
        try:
            status, ended = program.wait(seconds), True
        except DeadlineMissed:
            status, ended = program.stop(), False
        text = ("\n".join(stream.all) for stream in (program.stdout, program.stderr))
        return Outcome(status, *text), ended


_NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[-+]?\d+)?")


def kinds(text: list[str]) -> list[str]:
    """The different lines, numbers ignored, in the order of their first appearance."""
    return list(dict.fromkeys(_NUMBER.sub("#", line) for line in text))


def compare(plain: list[str], instrumented: list[str]) -> str:
    """How alike two outputs are, in the words of the module's docstring."""
    common = min(len(plain), len(instrumented))
    if plain[:common] == instrumented[:common] and (common or plain == instrumented):
        return "same"
    for earlier, later in itertools.permutations((plain, instrumented)):
        if later and later[0] in earlier:
            rest = earlier[earlier.index(later[0]) :]
            common = min(len(rest), len(later))
            if common >= 2 and rest[:common] == later[:common]:
                return "same, later"
    if kinds(plain) == kinds(instrumented):
        return "same kinds"
    if sorted(kinds(plain)) == sorted(kinds(instrumented)):
        return "other order"
    return "DIFFERENT"


def first_difference(plain: list[str], instrumented: list[str]) -> list[str]:
    pairs = itertools.zip_longest(kinds(plain), kinds(instrumented), fillvalue="(nothing)")
    for one, other in pairs:
        if one != other:
            return [f"  plain:        {one}", f"  instrumented: {other}"]
    return []


def check(checkout: Checkout, file: Path, variant: str, how: How, seconds: float) -> Result:
    """Runs one program both ways."""
    name = str(file.relative_to(checkout.folder)) + (f" ({variant})" if variant else "")
    result = Result(name)
    with tempfile.TemporaryDirectory() as folder:
        prefix = Path(folder)
        checkout.share(prefix)
        seconds = how.seconds or seconds
        plain, ended = run(checkout, file, how, prefix, seconds, instrumented=False)
        if missing := missing_modules(file, plain):
            result.difference = f"needs {', '.join(missing)}"
            return result
        limit = DEADLINE if ended else seconds
        instrumented, _ = run(checkout, file, how, prefix, limit, instrumented=True)
    result.plain = f"{plain.status}, {_size(plain)}"
    result.instrumented = f"{instrumented.status}, {_size(instrumented)}"
    verdicts = []
    for stream in ("stdout", "stderr"):
        one, other = (
            normalised(getattr(way, stream)).splitlines() for way in (plain, instrumented)
        )
        verdicts.append(compare(one, other))
        if verdicts[-1] == "DIFFERENT":
            result.details += [f"  {stream}", *first_difference(one, other)]
    if plain.status != instrumented.status:
        verdicts.append("DIFFERENT")
        result.details += [f"  exit status {plain.status} and {instrumented.status}"]
    order = ["same", "same, later", "same kinds", "other order", "DIFFERENT"]
    result.difference = max(verdicts, key=order.index)
    if "Traceback" in plain.stderr:
        result.difference += " (fails)"
        result.details.append(f"  plain: {plain.stderr.splitlines()[-1]}")
    return result


def _size(outcome: Outcome) -> str:
    return f"{len(outcome.stdout.splitlines())}+{len(outcome.stderr.splitlines())} lines"


def cases(checkout: Checkout, only: str) -> Iterator[tuple[Path, str, How]]:
    """Each program with each way to run it."""
    for file in checkout.programs():
        if not fnmatch(str(file), f"*{only}*"):
            continue
        ways = {
            key.partition("#")[2]: how
            for key, how in PROGRAMS.items()
            if str(file).endswith("/" + key.partition("#")[0])
        }
        for variant, how in (ways or {"": How()}).items():
            yield file, variant, how


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path)
    parser.add_argument("--seconds", type=float, default=6.0, help="for programs that do not end")
    parser.add_argument("--only", default="", metavar="PATTERN", help="of the path")
    parser.add_argument("--path", action="append", default=[], metavar="FOLDER")
    arguments = parser.parse_args()
    checkout = Checkout(arguments.folder.resolve(), arguments.path)

    row = "{:<76} {:<16} {:<16} {}"
    print(row.format("program", "plain", "instrumented", "difference"))
    different = 0
    for file, variant, how in cases(checkout, arguments.only):
        result = check(checkout, file, variant, how, arguments.seconds)
        print(row.format(*vars(result).values()), *result.details, sep="\n", flush=True)
        different += result.difference.startswith("DIFFERENT")
    print(f"{different} different" if different else "none is different")
    return 1 if different else 0


if __name__ == "__main__":
    sys.exit(main())
