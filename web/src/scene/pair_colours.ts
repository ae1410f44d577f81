/** Colours of the lower pairs. */
export const PAIR_COLOURS: Record<string, string> = {
  revolute: "#e8590c",
  prismatic: "#1c7ed6",
  helical: "#c2255c",
  cylindrical: "#5f3dc4",
  universal: "#7c4ddb",
  condyloid: "#9c36b5",
  spherical: "#099268",
  planar: "#846358",
  other: "#5c6678",
};
