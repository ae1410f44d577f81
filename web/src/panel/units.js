export const DECIMAL = /^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i;

export const UNITS = {
  rad: { name: "degrees", sign: "°", scale: 180 / Math.PI, digits: 1, open: [-Math.PI, Math.PI] },
  m: { name: "millimetres", sign: "mm", scale: 1000, digits: 1, open: [-1, 1] },
  1: { name: "percent", sign: "%", scale: 100, digits: 0, open: [0, 1] },
};
