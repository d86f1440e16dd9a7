"""Where footcal's equations are not the papers', row by row: printed, here, why."""

from __future__ import annotations

FOOT = (
    ("(3)–(5)", "nonlinear least squares", "linear least squares with rank and condition number, "
     "CoP counted from the middle of the cells, a small ridge", "the problem is linear; constant, "
     "x, y and forces are nearly collinear"),
    ("(8)", "CoP \"held or down-weighted\" below ε (5.2), \"invalid\" (3.2)", "absent",
     "a held CoP is no measurement"),
    ("(12), (13)", "least squares over all samples", "maximum a posteriori over the means of each "
     "stance", "the samples of one stance say one thing; rank 3 of 16 per stance"),
    ("(14)", "raw c and d", "centred and in prior sd, ω_S in these units",
     "around 8·10⁶ counts c and d are collinear to ten digits"),
    ("(14)", "all samples with Fz > ε", "without rows of unknown contact, lost samples and "
     "accelerations above 8 m/s²; no CoP residual where the cells' own force is below ε",
     "the safeguards of section 5.2"),
    ("(14)", "ω_F, ω_P from quiet standing", "from the standing before the first step, 0.5 s or "
     "more; refused without it", "a walk holds no quiet standing"),
    ("(14)", "ω_S \"fixed\"", "the one whose held parameters predict best what the motion demands, "
     "for the window and for the static assumption each", "the paper gives no value"),
)  # fmt: skip

HIPS = (
    ("(4)–(7)", "`(I + [s]) m g`", "a true rotation, and the acceleration of the turning leg "
     "(default)", "`(I + [s])` makes the weight low by the cosine of the tilt"),
    ("cost of s⁺", "sum of root mean squares and a standard deviation", "sum of their squares "
     "(`--method stepwise`)", "a least-squares solver squares what it is given"),
    ("cost of s⁻", "one standard deviation of a vector", "those of its three axes, squared and "
     "summed (`--method stepwise`)", "the paper leaves the sum unsaid"),
    ("(8), (9)", "foot wrenches about a fixed CoM, equal to the robot's weight", "wrenches on the "
     "chassis, equal to minus its weight (default)", "the robot's CoM moves with the legs"),
    ("(9)", "one sign for `m_k g` and G; `p̃' = R̃ (p̃ + p_BC)`", "the leg's weight down, G up; the "
     "arm of the turned frame (`--balance printed`)", "with the printed signs nothing balances"),
    ("BIC", "P residuals", "as printed, and with all 6 P in units of the noise",
     "six numbers per pose are fitted"),
)  # fmt: skip
