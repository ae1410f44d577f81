// The three.js that meshcat brings: one copy of it, in the page before this bundle.

export const { MeshCat } = globalThis;
export const { THREE } = MeshCat;
