// SPDX-License-Identifier: Apache-2.0
// Numbers and errors as people read them.

export function bytesText(bytes) {
  if (bytes < 1000) return `${bytes} B`;
  if (bytes < 1e6) return `${(bytes / 1e3).toPrecision(3)} kB`;
  return `${(bytes / 1e6).toPrecision(3)} MB`;
}

export const countText = (count) => (count < 1e4 ? String(count)
  : count < 1e6 ? `${(count / 1e3).toPrecision(3)} k` : `${(count / 1e6).toPrecision(3)} M`);

/** A length in units of the stream, and as a share of the diagonal. */
export function lengthText(length, units) {
  if (length === undefined) return '–';
  return `${length === 0 ? '0' : Number(length.toPrecision(2))}${units ? ` ${units}` : ''}`;
}
export function shareText(length, diagonal) {
  if (length === undefined) return '–';
  const percent = (100 * length) / diagonal;
  return percent < 1e-4 ? '< 0.0001 %' : `${Number(percent.toPrecision(2))} %`;
}

/** What a user can do about an error: [what happened, more]. */
export function errorText(error, hasMesh) {
  const stays = hasMesh ? ' What was decoded stays on the screen.' : '';
  const where = error.byteOffset ? ` (byte ${error.byteOffset})` : '';
  switch (error.code) {
    case 'NMC_ERR_NOT_NMC':
      return ['Not an nmc file.', `The first bytes are those of something else${kindText(error)}.`];
    case 'NMC_ERR_TRUNCATED':
      return error.byteOffset === 0 ? ['The file is empty.', 'There is nothing to show.']
        : ['The file is cut off.', `It ends early${where}.${stays}`];
    case 'NMC_ERR_CHECKSUM':
      return ['The file is damaged.', `Bytes were changed on their way${where}.${stays}`];
    case 'NMC_ERR_CORRUPT':
      return ['The file is broken.', `It breaks a rule of the format${where}: ${error.message}.${stays}`];
    case 'NMC_ERR_VERSION':
      return ['The file is too new.', 'It needs a later version of this page.'];
    case 'NMC_ERR_FEATURE':
      return ['The file cannot be shown.', `It uses something that this page does not know: ${error.message}.${stays}`];
    case 'NMC_ERR_LIMIT':
    case 'NMC_ERR_NO_MEMORY':
      return ['The file is too large for this page.', `${error.message}${where}.${stays}`];
    case 'NETWORK':
      return ['The connection is gone.', `It could not be taken up again${where}.${stays}`];
    case 'SOURCE_CHANGED':
      return ['The file changed.', `It was replaced on the server while it was read.${stays}`];
    case 'HTTP_404':
      return ['There is no such file.', 'The server answers 404: not found.'];
    default:
      if (/^HTTP_/.test(error.code ?? '')) return ['The server refuses the file.', error.message];
      return ['The file cannot be shown.', `${error.message ?? error}${where}.${stays}`];
  }
}

/** Names a few formats by their first bytes, which the page has kept in `error.firstBytes`. */
function kindText({ firstBytes }) {
  if (!firstBytes?.length) return '';
  const text = String.fromCharCode(...firstBytes.subarray(0, 5));
  if (text === 'DRACO') return ': a Draco file';
  if (text.startsWith('glTF')) return ': a GLB file';
  if (text.startsWith('ply')) return ': a PLY file';
  if (text.startsWith('PK')) return ': a ZIP file';
  if (text.startsWith('<')) return ': a web page';
  return '';
}
