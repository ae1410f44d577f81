/** How far a joint may be outside its limits [rad]. */
export const LIMIT = 1e-6;

/** What rounding may add to an angle [rad]; a search passes a limit by no more. */
export const ROUNDING = 1e-9;

/** The largest errors of a solution [m, rad]. */
export const VERIFIED = 1e-10;
