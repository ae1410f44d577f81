/**
 * A ray of three.js in plain numbers.
 *
 * @param {import("three").Ray} ray
 */
export const triples = ({ origin, direction }) => ({ origin: origin.toArray(), direction: direction.toArray() });
