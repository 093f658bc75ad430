"""The wheel as a user has it: installed, without the repository on the path."""

import contextlib
import copy
import io
import math
import os
import pickle
import random
import runpy
import signal
import tempfile
import threading
import time
import unittest
import warnings
from pathlib import Path

import joint_model as jm

EXAMPLE = Path(__file__).parents[1] / "examples" / "what_is_missing.py"


def example():
    """What the example leaves, run once."""
    if not hasattr(example, "names"):
        with contextlib.redirect_stdout(io.StringIO()) as printed:
            example.names = runpy.run_path(str(EXAMPLE))
        example.printed = printed.getvalue()
    return example.names


def another_day(joint, seed):
    """Another record of the example's joint, by another motion, rubbing a tenth harder."""
    names = example()
    harder = joint.replace("coulomb_nm = 0.014", "coulomb_nm = 0.0154")
    time = names["time"][:5000]
    voltage = [2.5 * math.sin(2 * math.pi * 1.3 * t) + 2.0 * math.sin(2 * math.pi * (1 + 5 * t) * t) for t in time]
    still = [0.0] * len(time)
    drive = {"t_s": time, "u_v": voltage, "i_a": still, "motor_angle_rad": still, "output_angle_rad": still}
    run = jm.simulate(drive, jm.Model.from_toml(harder), from_rest=True)
    noise = random.Random(seed)
    return {
        "t_s": time,
        "u_v": voltage,
        "i_a": [current + noise.gauss(0, 0.02) for current in run["i_a"]],
        "motor_angle_rad": names["counted"](run["motor_angle_rad"], 16384),
        "output_angle_rad": names["counted"](run["output_angle_rad"], 65536),
    }


class Results(unittest.TestCase):
    def test_the_example_names_what_it_hid_with_its_size(self):
        names = example()
        found = names["found"]
        self.assertTrue(names["checked"].passed, names["checked"])
        self.assertEqual(found.verdict, "effect", example.printed)
        first = found.effects[0]
        self.assertEqual((first.kind, first.location), ("cogging", "motor"))
        self.assertEqual(first.parameters["order"], 14)
        # Within four of its own standard errors.
        error = abs(first.parameters["amplitude_nm"] - 0.008)
        self.assertLess(error, 4 * first.standard_errors["amplitude_nm"])
        self.assertIn(("cogging", "motor"), found.model.effects)
        self.assertLess(found.gap.after, found.gap.before)
        budget = found.budget
        self.assertAlmostEqual(budget.named + budget.unnamed + budget.coloured + budget.white, 1, 6)
        self.assertIn("cogging (motor)", example.printed)
        self.assertIn("<html", found.report_html)
        self.assertEqual(found.residuals.samples, names["SAMPLES"])

    def test_the_improved_model_runs_closer_to_the_log_than_the_nominal(self):
        names = example()
        log = names["log"]
        missed = []
        for model in (names["nominal"], names["found"].model):
            run = jm.simulate(log, model)
            errors = [a - b for a, b in zip(run["motor_angle_rad"], log["motor_angle_rad"])]
            missed.append(math.sqrt(sum(error**2 for error in errors) / len(errors)))
        self.assertLess(missed[1], missed[0])

    def test_a_refit_tells_every_parameter_with_its_error(self):
        names = example()
        refit = jm.identify(names["log"], names["truth"])
        rows = {row.key: row for row in refit.parameters}
        constant = rows["motor.torque_constant_nm_per_a"]
        self.assertTrue(constant.determined)
        self.assertLess(abs(constant.value - 0.085), 0.085 * 0.01)
        self.assertGreater(constant.standard_error, 0)
        self.assertEqual(set(refit.raw["parameters"]), set(rows))

    def test_numbers_are_those_of_the_drive_where_they_are_asked_for(self):
        names = example()
        double = jm.simulate(names["drive"], names["truth"], from_rest=True)
        single = jm.simulate(names["drive"], names["truth"], from_rest=True, scalar="f32")
        self.assertNotEqual(list(double["current_a"]), list(single["current_a"]))
        largest = max(map(abs, double["current_a"]))
        # The bound of the step in single precision, 1 % of the largest.
        for one, other in zip(double["current_a"], single["current_a"]):
            self.assertLess(abs(one - other), 0.01 * largest)
        reference = jm.simulate(names["drive"], names["truth"], from_rest=True, method="reference")
        self.assertEqual(list(reference), list(double))


class Transfer(unittest.TestCase):
    def test_a_name_that_other_records_bear_out_stays_with_its_t(self):
        import pandas

        names = example()
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "other.csv"
            jm.Table(another_day(names["NOMINAL"] + names["HIDDEN"], 1)).to_csv(path)
            frame = pandas.DataFrame(another_day(names["NOMINAL"] + names["HIDDEN"], 2))
            found = jm.discover(names["log"], names["nominal"], transfer=[path, frame])
        first = found.effects[0]
        self.assertEqual((first.kind, first.location), ("cogging", "motor"))
        # It is what the fit says.
        self.assertLess(abs(first.borne_out - 1.0), 0.1)
        self.assertLess(first.borne_out_error, 0.1)
        # Beyond chance at 5 %, one-sided.
        self.assertGreater(first.transfer_t, 1.645)
        self.assertEqual(found.to_pandas()["transfer_t"][0], first.transfer_t)
        self.assertIn(f"t {first.transfer_t:.1f} on other records", str(found))
        self.assertIn("transfer=others", found.report_html)

    def test_a_name_that_another_record_speaks_against_is_only_possible(self):
        names = example()
        without = another_day(names["NOMINAL"], 3)
        found = jm.discover(names["log"], names["nominal"], transfer=without)
        self.assertNotIn("cogging", [own.kind for own in found.effects])
        self.assertNotIn("cogging", [kind for kind, _ in found.model.effects])
        self.assertIn("cogging", [own.kind for own in found.possible])
        # The same log alone bears the name out.
        self.assertIn("cogging", [own.kind for own in names["found"].effects])

    def test_without_other_records_there_is_no_t_of_them(self):
        self.assertEqual({own.transfer_t for own in example()["found"].effects}, {None})

    def test_another_record_is_checked_as_a_log_is(self):
        names = example()
        another = another_day(names["NOMINAL"], 4)
        current = {name: values for name, values in another.items() if name != "u_v"}
        with self.assertRaisesRegex(jm.JointError, "all need u_v, or none"):
            jm.discover(names["log"], names["nominal"], transfer=[current])
        backwards = {**another, "output_angle_rad": [-value for value in another["output_angle_rad"]]}
        with self.assertRaisesRegex(jm.JointError, "anyway=True"):
            jm.discover(names["log"], names["nominal"], transfer=[backwards])
        unknown = {**another, "humidity": another["t_s"]}
        with self.assertWarnsRegex(UserWarning, "humidity") as warned, self.assertRaises(jm.JointError):
            jm.discover(names["log"], names["nominal"], transfer=[unknown, current])
        self.assertEqual(warned.filename, __file__)


class Inputs(unittest.TestCase):
    def test_a_path_a_dict_and_a_data_frame_give_the_same(self):
        import numpy
        import pandas

        names = example()
        dict_of_lists = {name: values[:600] for name, values in names["log"].items()}
        frame = pandas.DataFrame(dict_of_lists).assign(note="text is ignored")
        arrays = {name: numpy.asarray(values) for name, values in dict_of_lists.items()}
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "log.csv")
            frame.to_csv(path, index=False, columns=list(dict_of_lists))
            runs = [jm.simulate(log, names["nominal"]) for log in (path, dict_of_lists, frame, arrays)]
        for run in runs[1:]:
            self.assertEqual(dict(run), dict(runs[0]))
        back = runs[0].to_pandas()
        self.assertEqual(list(back.columns), list(runs[0]))
        self.assertEqual(list(back["current_a"]), list(runs[0]["current_a"]))

    def test_a_simulation_is_a_log_and_its_file_is_read_back(self):
        names = example()
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "run.csv"
            names["run"].to_csv(path)
            with warnings.catch_warnings():
                # The states are unknown columns of a log.
                warnings.simplefilter("ignore")
                again = jm.simulate(path, names["truth"], from_rest=True)
        self.assertEqual(list(again["current_a"]), list(names["run"]["current_a"]))

    def test_what_is_wrong_is_told_with_its_place(self):
        names = example()
        log = {name: list(values[:600]) for name, values in names["log"].items()}
        log["t_s"][4] = log["t_s"][3]
        with self.assertRaises(jm.JointError) as raised:
            jm.simulate(log, names["nominal"])
        # Row 4 of numbers is line 6 of a file.
        self.assertIn("log:6", str(raised.exception))
        for wrong in ({"t_s": [0, 1]}, {"t_s": ["a"]}, {"t_s": [0.0], "u_v": [1.0, 2.0]}):
            with self.assertRaises(jm.JointError):
                jm.simulate(wrong, names["nominal"])
        with self.assertRaises(TypeError):
            jm.simulate(3, names["nominal"])
        with self.assertRaisesRegex(jm.JointError, "unknown key `moter`"):
            jm.Model.from_toml("[moter]")
        with self.assertRaisesRegex(jm.JointError, "the kinds are"):
            jm.discover(names["log"], names["nominal"], without=["clogging"])
        with self.assertRaisesRegex(jm.JointError, "it is one of f64, f32, fixed"):
            jm.simulate(names["log"], names["nominal"], scalar="f16")

    def test_a_model_is_compared_copied_and_pickled(self):
        truth = example()["truth"]
        self.assertEqual(pickle.loads(pickle.dumps(truth)), truth)
        self.assertEqual(copy.deepcopy(truth), truth)
        self.assertNotEqual(truth, example()["nominal"])
        self.assertEqual(jm.Model.from_toml(truth.to_toml()), truth)
        self.assertIn("cogging at motor", repr(truth))


class Shown(unittest.TestCase):
    def test_every_result_is_a_data_frame_and_a_figure(self):
        import matplotlib

        matplotlib.use("Agg")
        names = example()
        found = names["found"]
        frame = found.to_pandas()
        self.assertEqual(frame["kind"][0], "cogging")
        self.assertEqual(len(jm.check(names["log"], names["nominal"]).to_pandas().columns), 5)
        refit = jm.identify(names["log"], names["nominal"])
        self.assertIn("motor.rotor_inertia_kg_m2", refit.to_pandas().index)
        for figure in (found.plot(), refit.plot(), names["run"].plot(), names["seen"].plot()):
            with io.BytesIO() as file:
                figure.savefig(file, format="png")
                self.assertGreater(file.tell(), 10_000)
            self.assertTrue(any(axis.lines for axis in figure.axes))

    def test_an_observation_has_the_columns_of_joint_observe(self):
        seen = example()["seen"]
        for column in ("t_s", "total_friction_at_motor_nm", "stage1_windup_rad", "load_torque_nm_std"):
            self.assertIn(column, seen)
        self.assertEqual(len(seen.status), seen.samples)
        self.assertTrue(set("+".join(seen.status).split("+")) >= {"ok"}, set(seen.status))
        self.assertEqual(list(seen.to_pandas()["status"]), seen.status)

    def test_the_package_says_that_it_is_typed(self):
        folder = Path(jm.__file__).parent
        for file in ("py.typed", "_native.pyi"):
            self.assertTrue((folder / file).exists(), file)


class Running(unittest.TestCase):
    def test_other_threads_run_while_a_search_does(self):
        names = example()
        ticks = []
        done = threading.Event()

        def tick():
            while not done.is_set():
                ticks.append(time.monotonic())
                time.sleep(0.01)

        thread = threading.Thread(target=tick)
        thread.start()
        jm.identify(names["log"], names["nominal"])
        done.set()
        thread.join()
        # A lock held through the refit would leave one or two.
        self.assertGreater(len(ticks), 10)

    @unittest.skipUnless(hasattr(signal, "SIGINT") and os.name == "posix", "signals of POSIX")
    def test_an_interrupt_ends_a_search_and_the_next_one_is_whole(self):
        names = example()
        # A shell starts what runs in the background with interrupts ignored.
        before = signal.signal(signal.SIGINT, signal.default_int_handler)
        self.addCleanup(signal.signal, signal.SIGINT, before)
        threading.Timer(0.5, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
        with self.assertRaises(KeyboardInterrupt):
            jm.discover(names["log"], names["nominal"])
        again = jm.discover(names["log"], names["nominal"])
        self.assertFalse(any("interrupted" in reason for reason in again.reasons), again.reasons)
        whole = [(own.kind, own.location) for own in names["found"].effects]
        self.assertEqual([(own.kind, own.location) for own in again.effects], whole)


if __name__ == "__main__":
    unittest.main(verbosity=2)
