"""Write order and tearing: the payload first, its flag last, one byte per flag, nothing that one store could not write."""

from __future__ import annotations

import ctypes as c
from collections.abc import Callable, Iterator
from types import SimpleNamespace
from typing import Any, TypeVar

import pytest

from runtime.diagnostics.errors import Severity
from runtime.hli.alarms import AlarmHistory, AlarmLine, Report, send_report, take_report
from runtime.hli.control import ModeOrders
from runtime.hli.jobs import Jobs
from runtime.hli.layout import (
    TECHNO_UNITS,
    Activation,
    ActivationUnit,
    Alarm,
    Channel,
    Hli,
    MessageText,
    MessageUnit,
    Mode,
    ModeState,
    ModeStateUnit,
    OperatorActivation,
    OperatorUnit,
    PlcReport,
    State,
    TechnologyUnit,
)
from runtime.hli.memory import get_text, put_text
from runtime.hli.messages import MESSAGE, MessagePort, MessageTaker, Waiting
from runtime.hli.technology import Function, Kind, TechnologyPort, TechnologyTaker

pytestmark = pytest.mark.spec("hli.mech.publish-order")
_FLAGS = ("please_rw", "done_w", "semaphor_rw", "request_semaphor_rw", "command_semaphor_rw", "order_semaphor_rw")
Of = TypeVar("Of", bound=c.Structure)


class Log:
    """What is read and written of structures, in its order: "r command_w", "w please_rw"."""

    def __init__(self) -> None:
        self.entries: list[str] = []

    def spied(self, of: type[Of]) -> Of:
        """A structure that tells every access to one of its elements."""
        log, names = self.entries, {name for name, *_ in of._fields_}

        class Spied(of):  # type: ignore[misc, valid-type]
            def __getattribute__(self, name: str) -> Any:
                if name in names:
                    log.append(f"r {name}")
                return super().__getattribute__(name)

            def __setattr__(self, name: str, value: object) -> None:
                log.append(f"w {name}")
                super().__setattr__(name, value)

        return Spied()

    def during(self, action: Callable[[], object]) -> list[str]:
        """What one action accesses."""
        self.entries.clear()
        action()
        return list(self.entries)


def is_flag(entry: str) -> bool:
    return entry.split()[1] in _FLAGS


def publishes(entries: list[str], flag: str) -> None:
    """All that is written comes before the flag is raised, which is the last store."""
    writes = [entry for entry in entries if entry.startswith("w ")]
    assert writes[-1] == f"w {flag}"
    assert writes.count(f"w {flag}") == 1
    assert len(writes) > 1


def consumes(entries: list[str], flag: str) -> None:
    """The flag is looked at first; everything is copied before it is handed back, by the last store."""
    lowered = entries.index(f"w {flag}")
    payload = [i for i, entry in enumerate(entries) if entry.startswith("r ") and not is_flag(entry)]
    assert f"r {flag}" in entries[: payload[0]]
    assert payload[-1] < lowered
    assert [entry for entry in entries if entry.startswith("w ")][-1] == f"w {flag}"


# ---------------------------------------------------------------------------------------------------- the layout


def fields(of: type, path: str = "") -> Iterator[tuple[str, Any, int]]:
    """Every elementary element below a structure: path, type, offset in its structure."""
    for name, kind, *bits in of._fields_:  # type: ignore[attr-defined]
        assert not bits, f"{path}.{name} is a bit field: two writers would overwrite each other's bits"
        offset = getattr(of, name).offset
        while issubclass(kind, c.Array) and kind._type_ is not c.c_char:
            kind = kind._type_
        if issubclass(kind, c.Structure):
            yield from fields(kind, f"{path}.{name}")
        else:
            yield f"{path}.{name}", kind, offset


def test_every_element_is_written_by_one_store() -> None:
    seen = 0
    for path, kind, offset in fields(Hli):
        seen += 1
        if issubclass(kind, c.Array):
            continue  # text
        size = c.sizeof(kind)
        assert size in (1, 2, 4, 8), path
        assert offset % size == 0, f"{path} lies across a border"
        if path.rsplit(".", 1)[1] in _FLAGS or kind is c.c_bool:
            assert size == 1, path
    assert seen > 500


def test_structures_begin_where_their_greatest_element_may() -> None:
    hli = Hli()
    for of in (hli.channels[1], hli.axes[3], hli.operator[2], hli.alarms[5], hli.external_names[7]):
        assert (c.addressof(of) - c.addressof(hli)) % c.alignment(type(of)) == 0


# ---------------------------------------------------------------------------------------------------- CNC to PLC


def area(units: list[TechnologyUnit]) -> Any:
    channel = Channel(plc_present_w=True)
    late = [TechnologyUnit() for _ in range(TECHNO_UNITS)]
    return SimpleNamespace(
        plc_present_w=True,
        lc_reset=channel.lc_reset,
        techno_unit_std_sync=units,
        techno_unit_late_sync=late,
        used_units_std_sync_r=0,
        used_units_late_sync_r=0,
    )


def test_technology_functions() -> None:
    log = Log()
    units = [log.spied(TechnologyUnit) for _ in range(TECHNO_UNITS)]
    both = area(units)
    port, taker = TechnologyPort(both), TechnologyTaker(both)
    out = log.during(lambda: port.put(Function(Kind.M, 20, synch=2)))
    publishes(out, "please_rw")
    taken = taker.take()
    assert [t.function.number for t in taken] == [20]
    log.entries.clear()
    units[0].please_rw = True  # once more, to see it taken
    taker.restart()
    consumes([entry for entry in log.during(taker.take) if entry != "r sequence_r"], "please_rw")
    open_before = log.during(lambda: port.put(Function(Kind.M, 21, synch=2)))
    assert units[0].number_r == 20, "the unit of the first one is the PLC's"
    publishes(open_before, "please_rw")


def test_messages() -> None:
    log = Log()
    unit = log.spied(MessageUnit)
    channel: Any = SimpleNamespace(plc_present_w=True, msg_mc_control=unit)
    text = log.spied(MessageText)
    port = MessagePort(channel)
    port._request = text
    port.put(Waiting("half", False, 0))
    publishes(log.during(port.poll), "request_semaphor_rw")
    taker = MessageTaker(channel)
    put_text(unit.request_r, "contents", get_text(text, "contents"))
    unit.request_r.typ = MESSAGE
    offered = taker.offered()
    assert offered is not None
    assert offered.text == "half"
    assert log.during(lambda: taker.take(offered))[-1] == "w request_semaphor_rw"
    port.put(Waiting("second", False, 0))
    port.poll()
    assert offered.text == "half"
    assert log.during(lambda: taker.take(offered)) == ["r sequence_r"], "no other message is acknowledged by it"


def test_lines_of_the_alarm_history() -> None:
    log = Log()
    lines = [log.spied(Alarm) for _ in range(64)]
    hli: Any = SimpleNamespace(alarm_count_r=0, alarms=lines)
    history = AlarmHistory(hli)
    added = log.during(lambda: history.add(AlarmLine(0, 1, 2, 3, Severity.ERROR, "text")))
    writes = [entry for entry in added if entry.startswith("w ")]
    assert (writes[0], writes[-1]) == ("w sequence_r", "w sequence_r"), "it is no line while it is written"
    assert hli.alarm_count_r == 1


# ---------------------------------------------------------------------------------------------------- PLC and operator to CNC


def test_orders_of_the_mode_unit() -> None:
    log = Log()
    unit, operator = log.spied(ModeStateUnit), log.spied(OperatorUnit)
    orders = ModeOrders(unit, operator)
    unit.enable_w = True
    operator.order_w = ModeState(to_mode=Mode.MDI, to_state=State.ACTIVE, parameter=b"X1")
    operator.order_semaphor_rw = True
    log.entries.clear()
    handed_over = log.during(lambda: orders.take(present=True))
    request = handed_over.index("w request_semaphor_rw")
    assert handed_over.index("w request_r") < request
    assert handed_over.index("w order_semaphor_rw") == len(handed_over) - 1 - handed_over[::-1].index(
        "w order_semaphor_rw"
    )
    assert handed_over.index("r order_w") < handed_over.index("w order_semaphor_rw")
    unit.command_w = unit.request_r
    unit.request_semaphor_rw = False
    unit.command_semaphor_rw = True
    taken = log.during(lambda: orders.take(present=True))
    assert taken.index("r command_w") < taken.index("w command_semaphor_rw")
    orders.answer()
    unit.enable_w = False
    operator.order_semaphor_rw = True
    orders.take(present=True)
    answered = log.during(orders.answer)
    assert answered[-1] == "w order_semaphor_rw", "the answer stands before the operator sees that there is one"
    assert "w answer_r" in answered


@pytest.mark.parametrize("claimed", [False, True])
def test_jobs_by_hand(claimed: bool) -> None:
    log = Log()
    unit, operator = log.spied(ActivationUnit), log.spied(OperatorActivation)
    jobs = Jobs[Activation]([unit], operator)
    unit.enable_w = claimed
    operator.data_w, operator.semaphor_rw = Activation(log_ax_n=3), True
    first = log.during(lambda: jobs.take(present=True))
    assert first.index("r data_w") < first.index("w semaphor_rw")
    if not claimed:
        return
    assert first.index("w request_r") < first.index("w request_semaphor_rw") < first.index("w semaphor_rw")
    operator.data_w, operator.semaphor_rw = Activation(log_ax_n=4), True
    assert "w request_r" not in log.during(lambda: jobs.take(present=True)), "the PLC has not taken the first one"
    assert unit.request_r.log_ax_n == 3
    unit.command_w, unit.command_semaphor_rw = unit.request_r, True
    taken = log.during(lambda: jobs.take(present=True))
    assert taken.index("r command_w") < taken.index("w command_semaphor_rw")


def test_alarms_of_the_plc() -> None:
    log = Log()
    slot = log.spied(PlcReport)
    publishes(log.during(lambda: send_report(slot, Report(1, 2, "text"))), "semaphor_rw")
    assert log.during(lambda: send_report(slot, Report(3, 4, "other"))) == ["r semaphor_rw"], "it is the CNC's"
    consumes(log.during(lambda: take_report(slot)), "semaphor_rw")


# ---------------------------------------------------------------------------------------------------- what no flag guards


def test_a_text_that_changes_while_it_is_read_is_read_again() -> None:
    class Changing:
        """The writer is in the middle of it at the first two readings."""

        def __init__(self) -> None:
            self.readings = iter([b"old.nc", b"newd.nc", b"new.nc", b"new.nc"])

        @property
        def name_r(self) -> bytes:
            return next(self.readings)

    changing: Any = Changing()
    assert get_text(changing, "name_r") == "new.nc"
