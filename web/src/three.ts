// The three.js that meshcat brings: one copy of it, in the page before this bundle.

export import THREE = MeshCat.THREE;
