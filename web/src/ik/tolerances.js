// @ts-nocheck
// LIMIT: how far a joint may be outside [rad]; VERIFIED: errors of a solution [m, rad]; RIGID: the defect of a rotation,
// and EXACT one that is left as it is.
export const TOLERANCES = { LIMIT: 1e-9, VERIFIED: 1e-10, RIGID: 1e-6, EXACT: 1e-14 };

export const FAMILY_SEARCH = { STEPS: 180, HALVINGS: 48 };
