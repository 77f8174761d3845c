/* SPDX-License-Identifier: Apache-2.0
 * The client loop of nmc.h, compiled as C99. */
#include "libnmc/include/nmc/nmc.h"

int decode_in_c(const void* data, size_t size, uint32_t* face_count);

int decode_in_c(const void* data, size_t size, uint32_t* face_count) {
  nmc_decoder* decoder = NULL;
  nmc_status status = nmc_decoder_create(&decoder, NULL, NULL);
  nmc_event event = NMC_EVENT_HEADER;
  uint32_t vertex_count = 0;
  if (status == NMC_OK) status = nmc_decoder_feed(decoder, data, size);
  while (status == NMC_OK && event != NMC_EVENT_END) {
    status = nmc_decoder_next(decoder, &event);
    if (status == NMC_OK && event == NMC_EVENT_LAYER) {
      nmc_layer layer;
      status = nmc_decoder_current_layer(decoder, &layer);
      if (status == NMC_OK) status = nmc_decoder_mesh_size(decoder, layer.level, &vertex_count, face_count);
    }
  }
  nmc_decoder_destroy(&decoder);
  return (int)status;
}
