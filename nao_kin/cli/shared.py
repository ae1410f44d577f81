"""Options and arguments that several commands have: each with the same word, placeholder and help everywhere."""

from nao_kin.cli.options import argument, flag, option

JSON = flag("Print JSON.")
CSV = flag("Print CSV.")
DEG = flag("Use degrees in input and output; hands stay 0 to 1.")
OUTSIDE = "Treatment of joints outside their limits."
LIMITS = option(None, OUTSIDE, default="enforce")
FRAME = option("FRAME", "A frame; repeatable, or several with commas.")
REFERENCE = option("FRAME", "Give poses in this frame. Default: the root link.")
SEED = option("N", "Seed of random numbers.", default=0)
TIMELINE = option("NAME", "One of several motions in the file, by name or number.")
COLUMNS = option(
    "NAME=HEADING",
    "Read column NAME as HEADING: yaw=HeadYaw, 'ms=time [ms]'; NAME= skips the column; repeatable.",
)
IGNORE_OTHER = flag("Skip columns that are neither a joint nor a time.")
HIPS = option("RULE", "For two HipYawPitch joints that differ: average (default of a motion), left or right.")
MISSING = option("VALUE", "Values of joints without a column, empty cells and NaN: a posture, or a number.")
CONFIGURATIONS = argument("FILE", "CSV or JSON file of configurations, or a motion; - for standard input.", None)
TOLERANCE = option("M", "Overlap of links that is accepted [m].", default=0.0)
ALLOW = option("LINK,LINK", "Two links that may overlap; repeatable.")
EXACT = flag("Where hulls overlap, compare the meshes.")
CONTACTS = option("HEADINGS", "Columns of FILE, with commas: whether each sole touches the floor.")
GYRO = option("HEADINGS", "Columns of FILE, with commas: angular velocity about x, y and z [rad/s].")
FORCES = option("HEADINGS", "Columns of FILE, with commas: the force on each sole, or on each sensor.")
