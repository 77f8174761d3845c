// SPDX-License-Identifier: Apache-2.0
// Vite's defaults but for what a policy without inline modules asks for.
export default { build: { target: 'es2022', assetsInlineLimit: 0, modulePreload: { polyfill: false } } };
