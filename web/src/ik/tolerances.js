/** How far a joint may be outside its limits [rad]. */
export const LIMIT = 1e-6;

/** Two distances from limits that differ by less are alike [rad]. */
export const ALIKE = 1e-9;

/** The largest errors of a solution [m, rad]. */
export const VERIFIED = 1e-10;
