"""Which kernels are compiled after the warm-up, by programs of many kinds: run in a process of its own, it prints them as JSON.

In a process that has run other tests, these may have compiled what the warm-up misses.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from numba.core.dispatcher import Dispatcher

import runtime.scheduler.all_kernels
import runtime.scheduler.simulation
from runtime.config import load_machine
from runtime.config.compensation import Compensation
from runtime.config.fir_filter import FilterType, FirFilter
from runtime.config.machine import Machine
from runtime.kernels import warm_up
from runtime.scheduler.simulation import Simulation

PLATE = Path(runtime.scheduler.simulation.__file__).parents[1] / "demo" / "plate.nc"
SHORT = "\n".join(f"N{300 + i} X{60 + i * 0.4} Y{20 + (i % 3) * 0.2:.1f}" for i in range(1, 80))
TOUR = f"""%TOUR
N10 G90 G17 G162 S2000 M3
N20 G01 X20 F6000
N30 G03 X20 Y20 I0 J10
N40 G02 X10 Y30 Z-5 I0 J10
N50 #CONTOUR MODE ON [DEV, PATH_DEV 0.5]
N60 G01 X30 Y30
N70 X40 Y20
N80 X60 Y22
N90 #CONTOUR MODE [DIST_SOFT PATH_DIST=3]
N100 G261
N110 X60 Y20
N120 X70
N125 G260
#CONTOUR MODE OFF
{SHORT}
#HSC ON [BSPLINE PATH_DEV=0.2]
{SHORT.replace("N3", "N4")}
#HSC OFF
#SPLINE TYPE AKIMA
#SPLINE ON
N500 X60 Y10
N510 X50 Y30
N520 X40 Y10
N530 X30 Y30
#SPLINE OFF
#FILTER ON [ORDER=20]
N600 X60 Y30
N610 X30 Y10
#FILTER OFF
N700 G41 G00 X20 Y20 D1
N710 G01 X40
N720 G02 X50 Y30 I0 J10
N730 G01 Y50
N740 G40 X20
N741 G00 Z6 S1200 M3
N742 G95 F0.2 G01 X25
N743 G94 G33 Z2 K1
N744 G00 Z6
N745 M5
N746 G331 Z4 K1 S1200
N747 G332 Z6
N750 G00 X0 Y0 Z0 M5
N760 M30
"""


def compiled() -> dict[str, int]:
    """Kernel → how many signatures of it are compiled or loaded."""
    return {
        f"{module}.{name}": len(kernel.signatures)
        for module, loaded in list(sys.modules.items())
        if module.startswith("runtime.")
        for name, kernel in vars(loaded).items()
        if isinstance(kernel, Dispatcher) and kernel.__module__ == module
    }


def equipped(machine: Machine) -> Machine:
    """With filters, compensation and a storage for backward motion."""
    extra = {
        "fir_filter": FirFilter(type=FilterType.GAUSSIAN),
        "compensation": Compensation(backlash=0.02, velocity=5.0),
    }
    axes = tuple(
        axis.model_copy(update=extra) if axis.name in machine.channels[0].axes else axis for axis in machine.axes
    )
    channel = machine.channels[0].model_copy(update={"backward_storage": 500})
    plc = machine.plc.model_copy(update={"watchdog": 0.05})
    return machine.model_copy(update={"axes": axes, "channels": (channel,), "plc": plc})


def drive(simulation: Simulation, program: Path, most: int) -> None:
    """The program, with all that an operator does meanwhile, and with keyframes; `most` cycles of it."""
    assert simulation.run_until(simulation.ready, 20.0)
    simulation.start(program)
    operator = simulation.memory.hli.operator[0]
    channel = simulation.controller.channel
    orders = {
        600: ("override_w", 430),
        900: ("feedhold_w", True),
        1300: ("feedhold_w", False),
        1500: ("override_w", 1200),
        2000: ("backward_motion_w", True),
        2600: ("backward_motion_w", False),
        2700: ("single_block_w", True),
        3000: ("single_block_w", False),
    }
    for cycle in range(most):
        if order := orders.get(cycle):
            setattr(operator, *order)
        operator.continue_rw = True
        if simulation.recording is not None and cycle % 300 == 0:
            simulation.recording.border.keyframe_wanted = True
        simulation.cycle()
        if cycle > 3100 and not channel.active:
            break
    problems = [problem.text for problem in simulation.errors]
    assert not problems, problems


def main() -> None:
    warm_up()
    before = compiled()
    machine = equipped(load_machine(None))
    with TemporaryDirectory() as folder:
        tour = Path(folder) / "tour.nc"
        tour.write_text(TOUR)
        for program, ideal, record, most in (
            (tour, True, None, 20_000),
            (PLATE, False, Path(folder) / "recording", 3200),
        ):
            simulation = Simulation(machine, ideal_axes=ideal, record=record)
            drive(simulation, program, most)
            simulation.close()
    gained = {name: [before.get(name, 0), count] for name, count in compiled().items() if count != before.get(name, 0)}
    json.dump({"kernels": len(before), "gained": gained}, sys.stdout)


if __name__ == "__main__":
    main()
