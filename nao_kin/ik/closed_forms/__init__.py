"""All solutions for legs, arms and head by formulas: their equations, and the functions that ask them."""
