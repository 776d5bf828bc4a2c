"""The figures and bounds of apps/experiments on frames whose answers are known. python3 experiments_measures.py FOLDER"""

import math
import sys
import unittest

sys.dont_write_bytecode = True
sys.path.insert(0, sys.argv.pop(1))

import measures
import tables


def row(x=0.0, y=0.0, z=0.0, deg=0.0, visible=1.0, status="held", used="", on_occluder=""):
    return {"error_x_mm": str(x), "error_y_mm": str(y), "error_z_mm": str(z), "error_deg": str(deg),
            "visible": str(visible), "status": status, "mask_used": used, "mask_used_on_occluder": on_occluder}


class Measures(unittest.TestCase):
    def test_errors(self):
        self.assertEqual(measures.error(row(3, 4, -12, 2)), (13, 5, 12, 2))
        self.assertEqual(measures.largest([row(3, 4), row(0, 0, -12, 2)]), [12, 5, 12, 2])
        self.assertTrue(measures.within(row(10), 10, 2))
        self.assertFalse(measures.within(row(10.1), 10, 2))
        self.assertFalse(measures.within(row(0, deg=2.1), 10, 2))

    def test_wrong_is_held_and_off(self):
        self.assertTrue(measures.wrong(row(21)))
        self.assertFalse(measures.wrong(row(21, status="lost")))
        self.assertFalse(measures.wrong(row(19)))

    def test_before_hidden(self):
        rows = [row(visible=v) for v in (1, 0.5, 0.25, 0.6)]
        self.assertEqual(len(measures.before_hidden(rows, 0.25)), 2)
        self.assertEqual(len(measures.before_hidden(rows, 0.2)), 4)

    def test_held_again(self):
        def frames(*pairs):
            return measures.frames_until_held_again(
                [row(visible=v, status="held" if h else "lost", x=0 if h else 100) for v, h in pairs], 0.5)

        self.assertEqual(frames((1, 1), (0.1, 0), (0.5, 0), (0.7, 0), (0.9, 1)), 2)
        self.assertEqual(frames((1, 1), (0.1, 1), (0.4, 1), (0.7, 1)), 0)
        self.assertEqual(frames((1, 1), (0.9, 1)), 0)
        self.assertIsNone(frames((1, 1), (0.1, 0), (0.7, 0)))
        self.assertIsNone(frames((1, 1), (0.1, 0), (0.4, 0)))
        off = [row(visible=0.1), row(visible=0.9, x=30), row(visible=0.9, x=10)]
        self.assertEqual(measures.frames_until_held_again(off, 0.5), 1)

    def test_occluder_share(self):
        rows = [row(visible=0.5, used="100", on_occluder="1"), row(visible=0.8, used="300", on_occluder="3"),
                row(visible=1, used="999", on_occluder="0")]
        self.assertAlmostEqual(measures.occluder_share(rows), 0.01)
        self.assertTrue(math.isnan(measures.occluder_share([row()])))

    def test_spread(self):
        self.assertEqual(measures.spread([3, 1, 2.5]), "1.00 / 2.50 / 3.00")
        self.assertEqual(measures.spread([3, None, 1], 0), "1 / 3 / never")
        self.assertEqual(measures.spread([math.nan]), "-")


class Bounds(unittest.TestCase):
    def test_every_seed_must_be_good(self):
        two = [[row(0.9)], [row(1.1)]]
        bound = tables.largest_errors("2", "", "", two, {"mm": 1})[0]
        self.assertFalse(bound.met())
        self.assertEqual(bound.cells()[-2:], ["1 of 2", "**missed**"])
        self.assertTrue(tables.largest_errors("2", "", "", two, {"mm": 1.2})[0].met())

    def test_eight_of_ten(self):
        lost, kept = [row(20)], [row(1)]
        self.assertTrue(tables.tests_off("1", "", "", [lost] * 8 + [kept] * 2)[0].met())
        self.assertFalse(tables.tests_off("1", "", "", [lost] * 7 + [kept] * 3)[0].met())
        # What happens while hardly anything is visible proves nothing.
        hidden = [row(1), row(200, visible=0.2)]
        self.assertFalse(tables.tests_off("1", "", "", [hidden] * 10)[0].met())

    def test_held(self):
        self.assertTrue(tables.held_throughout("2", "", "", [[row(49)]])[0].met())
        self.assertFalse(tables.held_throughout("2", "", "", [[row(1, status="lost")]])[0].met())

    def test_cube(self):
        good = [row(), row(visible=0.1, x=5), row(visible=0.3, x=1.9), row(visible=0.6), row()]
        self.assertTrue(all(bound.met() for bound in tables.cube_default("4", "", [good])))

        def missed(*rows):
            return [i for i, bound in enumerate(tables.cube_default("4", "", [list(rows)])) if not bound.met()]

        self.assertEqual(missed(row(2.1), *good), [0])
        self.assertEqual(missed(row(deg=0.6), *good), [1])
        self.assertEqual(missed(row(), row(visible=0.1), row(2.1, visible=0.2), row()), [2])
        self.assertEqual(missed(row(), row(visible=0.1, x=25), row()), [4])
        lost = [row(visible=0.9, status="lost", x=100)] * 11
        self.assertEqual(missed(row(), row(visible=0.1), *lost, row()), [5])


unittest.main(argv=sys.argv[:1])
