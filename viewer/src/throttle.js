// SPDX-License-Identifier: Apache-2.0
// A slow line on this side of the network: pieces of a body are handed on no faster than `kilobitsPerSecond()` allows,
// which is asked anew each time; 0 is as fast as they come. Every byte that passes is kept in `received`.

const PIECE = 2048;
const wait = (milliseconds) => new Promise((resolve) => { setTimeout(resolve, milliseconds); });

/** All that has arrived of one stream. */
export class ReceivedBytes {
  #pieces = [];
  length = 0;
  push(piece) {
    this.#pieces.push(piece.slice());
    this.length += piece.length;
  }
  /** The first `size` bytes in one piece. */
  take(size) {
    const bytes = new Uint8Array(Math.min(size, this.length));
    let at = 0;
    for (const piece of this.#pieces) {
      if (at >= bytes.length) break;
      const part = piece.subarray(0, bytes.length - at);
      bytes.set(part, at);
      at += part.length;
    }
    return bytes;
  }
}

/** The pieces of an iterable of Uint8Array, slowed down. */
export async function* throttled(pieces, kilobitsPerSecond) {
  let begin = performance.now();
  let sent = 0;
  let speed = 0;
  for await (const piece of pieces) {
    for (let at = 0; at < piece.length;) {
      if (kilobitsPerSecond() !== speed) {
        speed = kilobitsPerSecond();
        begin = performance.now();
        sent = 0;
      }
      const part = speed === 0 ? piece.subarray(at) : piece.subarray(at, at + PIECE);
      at += part.length;
      sent += part.length;
      yield part;
      const due = speed === 0 ? 0 : begin + (8 * sent) / speed - performance.now();
      if (due > 1) await wait(due);
    }
  }
}

/** fetch() whose bodies are slow. */
export const throttledFetch = (kilobitsPerSecond) => async (url, init) => {
  const response = await fetch(url, init);
  if (!response.ok || !response.body) return response;
  const pieces = throttled(piecesOf(response.body), kilobitsPerSecond);
  const body = new ReadableStream({
    async pull(controller) {
      const { done, value } = await pieces.next();
      if (done) controller.close();
      else controller.enqueue(value);
    },
    async cancel(reason) {
      await response.body.cancel(reason).catch(() => {});
    },
  }, { highWaterMark: 0 });
  return new Response(body, { status: response.status, headers: response.headers });
};

async function* piecesOf(body) {
  const reader = body.getReader();
  try {
    for (let part; !(part = await reader.read()).done;) yield part.value;
  } finally {
    reader.releaseLock();
  }
}
