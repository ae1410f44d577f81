import type { Ray } from "three";

/** A ray of three.js in plain numbers. */
export const triples = ({ origin, direction }: Ray) => ({ origin: origin.toArray(), direction: direction.toArray() });
