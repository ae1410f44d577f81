import js from "@eslint/js";
import globals from "globals";
import typescript from "typescript-eslint";

export default [
  { ignores: ["build/"] },
  js.configs.recommended,
  {
    languageOptions: { ecmaVersion: 2022, sourceType: "module" },
    rules: {
      curly: ["error", "multi-line"],
      eqeqeq: "error",
      "no-shadow": ["error", { builtinGlobals: false }],
      "no-unused-vars": ["error", { args: "after-used" }],
      "no-use-before-define": ["error", { functions: false }],
      "no-var": "error",
      "object-shorthand": "error",
      "prefer-const": "error",
      "prefer-template": "error",
    },
  },
  {
    files: ["src/**/*.ts"],
    languageOptions: { globals: globals.browser, parser: typescript.parser },
    plugins: { "@typescript-eslint": typescript.plugin },
    rules: {
      // tsc says it, and knows types.
      "no-undef": "off",
      "no-unused-vars": "off",
      "no-redeclare": "off",
      "no-shadow": "off",
      "@typescript-eslint/no-shadow": "error",
      "no-use-before-define": "off",
      // A function that runs later may use what is defined below it.
      "@typescript-eslint/no-use-before-define": [
        "error",
        { functions: false, classes: false, variables: false, ignoreTypeReferences: true },
      ],
    },
  },
  { files: ["tests/**", "*.js"], languageOptions: { globals: globals.node } },
];
