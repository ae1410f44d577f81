// A distance [m] that rounding may add to the reach.
const ROUNDING = 1e-12;
// The ankle of a straight leg may be out of reach by this [m], in a rounded pose for instance.
const STRETCHED = 1e-6;
// The angle of the knee below which it is straight.
const STRAIGHT = 1e-7;

/** The triangle of hip, knee and ankle, in the plane of the leg. */
export class LegTriangle {
  longest: number;
  shortest: number;

  /**
   * @param thigh [m]
   * @param tibia [m]
   */
  constructor(
    public thigh: number,
    public tibia: number,
  ) {
    /** The largest and the least distance of hip and ankle. */
    this.longest = thigh + tibia;
    this.shortest = Math.abs(thigh - tibia);
  }

  /**
   * A distance of hip and ankle, or the one nearest to it that the leg can have, where it is off by up to `STRETCHED`.
   */
  reached(far: number) {
    const reached = Math.min(Math.max(far, this.shortest), this.longest);
    const short = Math.abs(far - reached);
    return short <= ROUNDING || short > STRETCHED ? far : reached;
  }

  /** By how much a distance of hip and ankle is too large or too small [m]; 0 where the leg can have it. */
  beyond(far: number) {
    const beyond = Math.max(far - this.longest, this.shortest - far);
    return beyond > ROUNDING ? beyond : 0;
  }

  /**
   * The angles of the knee with hip and ankle so far apart, by the law of cosines for the half angle, which loses no
   * digits at either end; straight or folded it has one.
   */
  knees(far: number) {
    const { longest, shortest } = this;
    const stretched = Math.sqrt(Math.max(0, (longest - far) * (longest + far)));
    const folded = Math.sqrt(Math.max(0, (far - shortest) * (far + shortest)));
    const knee = 2 * Math.atan2(stretched, folded);
    if (knee < STRAIGHT) return [0];
    return knee > Math.PI - STRAIGHT ? [Math.PI] : [knee, -knee];
  }

  /** x and z of the ankle from the hip, in the axes of the thigh. */
  ankleFromHip(knee: number) {
    return [-this.tibia * Math.sin(knee), -this.thigh - this.tibia * Math.cos(knee)];
  }

  /** x and z of the hip from the ankle, in the axes of the foot with the ankle at zero. */
  hipFromAnkle(knee: number) {
    return [-this.thigh * Math.sin(knee), this.tibia + this.thigh * Math.cos(knee)];
  }
}
