"""Tolerances and thresholds that several rooms share."""

# A value that exceeds a limit by no more than this [rad, m or ratio] is accepted unchanged: files have single precision
# (1e-7 of a value) or six decimals (5e-7), and limits converted from degrees are rounded.
LIMIT_TOLERANCE = 1e-6
# Two values for one motor agree if they differ by less than the resolution of single precision.
COUPLING_TOLERANCE = 1e-6
# A quaternion whose norm differs from 1 by less than this is accepted, and divided by its norm.
UNIT_TOLERANCE = 1e-6
# How far above the floor a point may be and still touch it [m].
TOUCHING = 0.002
# How much lower the other sole must be to become the support [m].
LOWER = 1e-3
# From this number of configurations on, the kernels are used. When loaded, they are as fast as Pinocchio for 3 to 8
# configurations, but loading them takes as long as tens of thousands of configurations, too long for a handful.
CROSSOVER = 32
