// What the pure modules call their numbers. Matrices are flat and go row by row, as NumPy ravels them.

export type Vector = [number, number, number];

/** Three rows of three. */
export type Matrix3 = [number, number, number, number, number, number, number, number, number];

/** A 3×3 matrix that is orthogonal with determinant 1. */
export type Rotation = Matrix3;

/** A homogeneous transform, four rows of four: the pose of a frame in another. */
export type Pose = [...Row, ...Row, ...Row, ...Row];

type Row = [number, number, number, number];
