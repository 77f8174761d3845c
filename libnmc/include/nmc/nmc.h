/* SPDX-License-Identifier: Apache-2.0
 *
 * nmc.h: decodes .nmc streams (progressive normal meshes). C99, no dependencies, no globals, no threads.
 *
 * A stream is a header and a sequence of layers; each layer refines the mesh of the one before. The header holds a
 * table that tells of every layer how many bytes of the stream it needs, which level it is meant to be shown at,
 * and its measured error, so a client can choose what to fetch before it has fetched it.
 *
 * The complete client loop:
 *
 *   nmc_decoder* decoder = NULL;
 *   nmc_status status = nmc_decoder_create(&decoder, NULL, NULL);
 *   int done = status != NMC_OK;
 *   while (!done) {
 *     nmc_event event;
 *     status = nmc_decoder_next(decoder, &event);
 *     if (status == NMC_NEED_MORE_INPUT) {
 *       size_t size = fread(bytes, 1, sizeof bytes, file);
 *       status = size > 0 ? nmc_decoder_feed(decoder, bytes, size) : nmc_decoder_finish(decoder);
 *       done = size == 0 || status != NMC_OK;
 *     } else if (status != NMC_OK) {
 *       done = 1;                                 // what was shown last still stands
 *     } else if (event == NMC_EVENT_LAYER) {      // show the mesh, now better than before
 *       nmc_layer layer;
 *       uint32_t vertex_count, face_count;
 *       nmc_decoder_current_layer(decoder, &layer);
 *       nmc_decoder_mesh_size(decoder, layer.level, &vertex_count, &face_count);
 *       ...                                       // allocate; indices only when layer.level has changed
 *       nmc_decoder_read_indices(decoder, layer.level, indices, (size_t)3 * face_count);
 *       nmc_decoder_read_positions(decoder, layer.level, positions, 3 * sizeof(float), vertex_count);
 *     } else if (event == NMC_EVENT_END) {
 *       done = 1;
 *     }
 *   }
 *   if (status != NMC_OK) {
 *     nmc_error_detail detail;
 *     nmc_decoder_error(decoder, &detail);
 *     fprintf(stderr, "%s at byte %llu: %s\n", nmc_status_name(status), (unsigned long long)detail.byte_offset,
 *             detail.message);
 *   }
 *   nmc_decoder_destroy(&decoder);
 *
 * Any bytes whatsoever may be fed: the outcome is a mesh or a status, never a crash, and never more memory than the
 * limits allow. Every index read is below the vertex count and every coordinate is finite. The same bytes give the
 * same bits on every machine.
 *
 * Thread safety: one decoder belongs to one thread at a time; different decoders are independent.
 */
#ifndef NMC_NMC_H_
#define NMC_NMC_H_

#include <stddef.h>
#include <stdint.h>

#if defined(NMC_SHARED) && defined(_WIN32)
#define NMC_API __declspec(dllexport)
#elif defined(__GNUC__)
#define NMC_API __attribute__((visibility("default")))
#else
#define NMC_API
#endif

/* Version of this header: 10000 * major + 100 * minor + patch. */
#define NMC_VERSION 100

#ifdef __cplusplus
extern "C" {
#endif

/* ---- status ---------------------------------------------------------------------------------------------------- */

/* Zero: done. Positive: not an error. Negative: an error. The values are part of the ABI and are never reused. */
typedef enum nmc_status {
  NMC_OK = 0,
  NMC_NEED_MORE_INPUT = 1,  /* nmc_decoder_next only: feed, then call again */
  NMC_ERR_NOT_NMC = -10,    /* the first bytes are not those of a stream */
  NMC_ERR_VERSION = -12,    /* a version of the format that this library does not know */
  NMC_ERR_FEATURE = -14,    /* a valid stream with something that this library does not know */
  NMC_ERR_CORRUPT = -20,    /* the stream breaks a rule of the format */
  NMC_ERR_CHECKSUM = -22,   /* bytes were changed on their way */
  NMC_ERR_TRUNCATED = -24,  /* nmc_decoder_finish only: the stream ends early; all complete layers are readable */
  NMC_ERR_LIMIT = -30,      /* a limit of nmc_limits or of the format is passed */
  NMC_ERR_NO_MEMORY = -32,  /* the allocation function returned null */
  NMC_ERR_STOPPED = -34,    /* should_stop asked for it */
  NMC_ERR_ARGUMENT = -40,   /* null, or a count or level that does not fit: a mistake of the caller */
  NMC_ERR_STATE = -42       /* asked before the event that makes it legal: a mistake of the caller */
} nmc_status;

/* "NMC_ERR_CORRUPT" and so on; "NMC_UNKNOWN" for a value that is none. Never null. */
NMC_API const char* nmc_status_name(nmc_status status);

/* NMC_VERSION of the library. */
NMC_API uint32_t nmc_version(void);

/* Version of the format that this library reads. */
NMC_API uint32_t nmc_format_version(void);

/* ---- creation -------------------------------------------------------------------------------------------------- */

/* A decoder: opaque. */
typedef struct nmc_decoder nmc_decoder;

/* What a stream may cost. Start from nmc_default_limits() and change fields; a limit that is passed gives
 * NMC_ERR_LIMIT before the memory is taken. */
typedef struct nmc_limits {
  size_t struct_size;          /* sizeof(nmc_limits): lets the structure grow in later versions */
  uint64_t max_memory;         /* bytes the decoder may hold at any time; default 4 GiB, 1 GiB where size_t is 32 bits */
  uint64_t max_vertices;       /* of the level decoded or read; default 100 million */
  uint32_t max_base_vertices;  /* default 2^20 */
  uint32_t max_levels;         /* default 14, the most that the format has */
  uint32_t max_chunk_size;     /* bytes; default 2^30 */
  /* Asked every few milliseconds of work when not null; a result other than zero ends it with NMC_ERR_STOPPED. Must
   * not call back into the decoder. */
  int (*should_stop)(void* user);
  void* should_stop_user;
} nmc_limits;

NMC_API nmc_limits nmc_default_limits(void);

/* Where memory comes from. `allocate` returns memory aligned as malloc does, or null; `release` gets what `allocate`
 * returned, never null. Both are called only from within calls on the decoder. */
typedef struct nmc_allocator {
  void* (*allocate)(void* user, size_t size);
  void (*release)(void* user, void* pointer);
  void* user;
} nmc_allocator;

/* Creates a decoder in *decoder. `limits` and `allocator` may be null: defaults, and malloc and free; they are copied.
 * NMC_ERR_ARGUMENT, NMC_ERR_LIMIT or NMC_ERR_NO_MEMORY; then *decoder is null. */
NMC_API nmc_status nmc_decoder_create(nmc_decoder** decoder, const nmc_limits* limits, const nmc_allocator* allocator);

/* Lends the decoder threads. `run_tasks` has to call task(context, i) once for each i below task_count, from any threads,
 * and to return when all are done. It is called from within calls that read positions or normals; tasks allocate nothing,
 * call nothing back and do not throw. Results are the same bits with any number of threads. Null ends it. Kept by
 * nmc_decoder_reset. In the WebAssembly module it does nothing. */
typedef void (*nmc_run_tasks)(void* user, void (*task)(void* context, uint32_t index), void* context,
                              uint32_t task_count);
NMC_API nmc_status nmc_decoder_set_threads(nmc_decoder* decoder, nmc_run_tasks run_tasks, void* user);

/* Gives all memory back and sets *decoder to null. Null and pointers to null are allowed. */
NMC_API void nmc_decoder_destroy(nmc_decoder** decoder);

/* As if newly created with the same limits and allocator. Ends every error state. */
NMC_API nmc_status nmc_decoder_reset(nmc_decoder* decoder);

/* ---- input and events ------------------------------------------------------------------------------------------ */

typedef enum nmc_event {
  /* When: the header is complete and valid. How often: once, first of all events. Now legal: nmc_decoder_info,
   * nmc_decoder_layer, nmc_decoder_select_layer. */
  NMC_EVENT_HEADER = 1,
  /* When: all bytes of the next row of the layer table have arrived, their checksums are right and they are decoded.
   * How often: once per row, in order, after HEADER. Now legal: nmc_decoder_current_layer, and everything that reads
   * the mesh, at any level up to nmc_info.level_count. What is read is exactly the state after this row, however much
   * more has been fed. */
  NMC_EVENT_LAYER = 2,
  /* When: directly after the LAYER event of the last row. How often: once, last of all events; a further call gives
   * NMC_NEED_MORE_INPUT. Nothing needs to be fed any more; the mesh stays readable. */
  NMC_EVENT_END = 3
} nmc_event;

/* Appends `size` bytes of the stream; they are copied. Any split of a stream into pieces gives the same events.
 * Decodes nothing by itself. NMC_ERR_LIMIT or NMC_ERR_NO_MEMORY when they cannot be held, and then nothing is
 * appended; after an error of nmc_decoder_next, that error. */
NMC_API nmc_status nmc_decoder_feed(nmc_decoder* decoder, const void* data, size_t size);

/* Works towards the next event. NMC_OK and *event; or NMC_NEED_MORE_INPUT; or an error, which stays until reset and is
 * described by nmc_decoder_error. After an error nothing more can be fed, but the layers that were complete before it
 * remain readable, unless the stream was written to break (its checksums are right, its contents are not). */
NMC_API nmc_status nmc_decoder_next(nmc_decoder* decoder, nmc_event* event);

/* Tells that no more bytes will come. NMC_OK when every layer was complete; NMC_ERR_TRUNCATED otherwise;
 * NMC_ERR_CORRUPT when bytes follow the last layer. Call it after nmc_decoder_next has asked for more input. The mesh
 * stays readable. */
NMC_API nmc_status nmc_decoder_finish(nmc_decoder* decoder);

/* What went wrong, and where. `status` is NMC_OK when nothing did. */
typedef struct nmc_error_detail {
  nmc_status status;
  uint64_t byte_offset;      /* of the header or of the chunk at fault, from the start of the stream */
  uint32_t chunk_type;       /* type byte of the chunk at fault; 0 when it is none */
  const char* spec_section;  /* of format-spec.md, such as "5.3"; "" when there is none. Never null, never freed. */
  const char* message;       /* one sentence without a full stop; "" when there is none. Never null, never freed. */
} nmc_error_detail;

/* The first error of nmc_decoder_next or nmc_decoder_finish, or else the error of the last other call. */
NMC_API nmc_status nmc_decoder_error(const nmc_decoder* decoder, nmc_error_detail* detail);

/* ---- header and layer table ------------------------------------------------------------------------------------ */

typedef enum nmc_units {
  NMC_UNITS_UNKNOWN = 0,
  NMC_UNITS_MILLIMETRE,
  NMC_UNITS_CENTIMETRE,
  NMC_UNITS_METRE,
  NMC_UNITS_INCH,
  NMC_UNITS_FOOT,
  NMC_UNITS_KILOMETRE
} nmc_units;

typedef enum nmc_up_axis { NMC_UP_UNKNOWN = 0, NMC_UP_Y = 1, NMC_UP_Z = 2 } nmc_up_axis;

typedef struct nmc_info {
  uint64_t header_size;           /* bytes before the first layer */
  uint64_t stream_size;           /* bytes of the whole stream */
  uint32_t layer_count;           /* rows of the layer table, at least 1 */
  uint32_t level_count;           /* the finest level; level 0 is the base mesh, each level has 4 times the faces */
  uint32_t quality_layer_count;   /* how often the coefficients are refined, plus one */
  uint32_t base_vertex_count;
  uint32_t base_face_count;
  uint64_t input_vertex_count;    /* of the mesh that was encoded; 0 when not recorded */
  uint64_t input_triangle_count;
  double box_min[3], box_max[3];  /* bounding box of the mesh that was encoded, in model units */
  double diagonal;                /* length of that box's diagonal */
  double grid_step;               /* spacing of the grid that the base vertices lie on */
  nmc_units units;
  nmc_up_axis up_axis;
  int has_creases;
  int has_colors;
  uint32_t region_count;          /* parts of the surface that can be had alone; 0: it is not divided */
} nmc_info;

/* The header. Legal from NMC_EVENT_HEADER on. */
NMC_API nmc_status nmc_decoder_info(const nmc_decoder* decoder, nmc_info* info);

/* One row of the layer table. Errors are those that the encoder measured, in model units, never understated. */
typedef struct nmc_layer {
  uint32_t index;
  uint32_t level;       /* at which the layer is meant to be shown */
  uint64_t end_offset;  /* the first end_offset bytes of the stream give this layer */
  uint64_t face_count;  /* of the level */
  double rms_error;     /* root mean square distance to the mesh that was encoded, both ways */
  double max_error;     /* largest distance, both ways */
  int has_error;        /* 0: the encoder has not measured this layer, and both errors are 0 */
  int32_t region;       /* whose bytes the row holds, 0 ... region_count - 1; -1: those of the whole surface, needed by all */
} nmc_layer;

/* Row `index` of the table. Legal from NMC_EVENT_HEADER on. */
NMC_API nmc_status nmc_decoder_layer(const nmc_decoder* decoder, uint32_t index, nmc_layer* layer);

/* The row whose state is read: that of the last NMC_EVENT_LAYER. */
NMC_API nmc_status nmc_decoder_current_layer(const nmc_decoder* decoder, nmc_layer* layer);

/* Leaves out the next row of the table, whose bytes will not be fed: what it would have refined stays coarse, without
 * cracks. The row must be one of a region, and none of its bytes may have been fed: feed no farther than the row before
 * ends, and after this call go on behind the row. No event follows; the next row is the one after. NMC_ERR_STATE when
 * that is not so. The errors of all later rows are then those of the parts that came. */
NMC_API nmc_status nmc_decoder_skip_layer(nmc_decoder* decoder);

/* What nmc_decoder_select_layer goes by. */
typedef enum nmc_criterion {
  NMC_BY_MAX_ERROR = 1,  /* the first row whose max_error is at most `value` model units */
  NMC_BY_RMS_ERROR = 2,  /* the first row whose rms_error is at most `value` model units */
  NMC_BY_FACES = 3,      /* the last row with at most `value` faces */
  NMC_BY_BYTES = 4,      /* the last row that ends within the first `value` bytes */
  NMC_BY_LEVEL = 5       /* the last row that is shown at level `value` or coarser */
} nmc_criterion;

/* The row of the table that a client wants. Where no row meets the criterion the nearest is given (the last for
 * errors, the first for the others) and *is_met is 0. `is_met` may be null. Legal from NMC_EVENT_HEADER on. */
NMC_API nmc_status nmc_decoder_select_layer(const nmc_decoder* decoder, nmc_criterion criterion, double value,
                                            uint32_t* index, int* is_met);

/* ---- the mesh: legal from the first NMC_EVENT_LAYER on ---------------------------------------------------------- */

/* Counts of `level`, 0 ... level_count. Levels above that of the current layer are legal too: what the stream has not
 * described yet is predicted. NMC_ERR_LIMIT when the level is larger than the limits, or than so few bytes may
 * describe. */
NMC_API nmc_status nmc_decoder_mesh_size(const nmc_decoder* decoder, uint32_t level, uint32_t* vertex_count,
                                         uint32_t* face_count);

/* Three vertex indices per face, counter-clockwise seen from outside. `index_count` is 3 * face_count. They depend on
 * the base mesh and the level alone, so a client reads them once per level. Vertices keep their numbers on finer
 * levels. */
NMC_API nmc_status nmc_decoder_read_indices(nmc_decoder* decoder, uint32_t level, uint32_t* indices,
                                            size_t index_count);

/* The region of each face of level 0; a face of level l lies in that of face >> (2 l). `face_count` is
 * nmc_info.base_face_count. NMC_ERR_STATE when there are no regions. */
NMC_API nmc_status nmc_decoder_read_regions(nmc_decoder* decoder, uint8_t* regions, uint32_t face_count);

/* Positions of all vertices of `level` in model units, in the state of the current layer. Vertex i goes to the three
 * values at byte i * stride; stride is at least their size and a multiple of that of one value. Work is proportional
 * to what has changed since the last call, plus the copy. */
NMC_API nmc_status nmc_decoder_read_positions(nmc_decoder* decoder, uint32_t level, float* positions, size_t stride,
                                              uint32_t vertex_count);
NMC_API nmc_status nmc_decoder_read_positions_double(nmc_decoder* decoder, uint32_t level, double* positions,
                                                     size_t stride, uint32_t vertex_count);

/* Unit normals of all vertices of `level`: the mean of the faces around, weighted by area; (0, 0, 1) where that
 * vanishes. Layout as nmc_decoder_read_positions. */
NMC_API nmc_status nmc_decoder_read_normals(nmc_decoder* decoder, uint32_t level, float* normals, size_t stride,
                                            uint32_t vertex_count);

/* How each vertex of `level` was set off its prediction, for pictures and statistics: the signed length along the
 * predicted normal in model units, 0 for base vertices and for what the stream has not described yet, and 1 in
 * `is_off_normal` where the stream also moves the vertex sideways. Either array may be null. O(vertex_count). */
NMC_API nmc_status nmc_decoder_read_offsets(nmc_decoder* decoder, uint32_t level, float* normal_offsets,
                                            uint8_t* is_off_normal, uint32_t vertex_count);

/* ---- values at the vertices: colours and others ------------------------------------------------------------------ */

#define NMC_ATTRIBUTE_COLOR 1 /* red, green, blue as sRGB, then opacity where there are four components */

typedef struct nmc_attribute {
  uint32_t index;
  uint32_t kind;            /* NMC_ATTRIBUTE_COLOR, or what the application calls it: 64 ... 255 */
  uint32_t component_count; /* 1 ... 4 */
  uint32_t bit_count;       /* values are 0 ... 2^bit_count - 1 */
  uint32_t finest_level;    /* values are coded up to this level and interpolated beyond */
  uint32_t levels_complete; /* levels whose values have come: 0 at the beginning, finest_level + 1 at the end */
  uint64_t byte_count;      /* of the chunks that brought them */
} nmc_attribute;

/* Attribute `index`, 0, 1, ... as long as the stream has one; NMC_ERR_ARGUMENT beyond. nmc_info.has_colors tells whether
 * one of them is a colour. Legal from NMC_EVENT_HEADER on. */
NMC_API nmc_status nmc_decoder_attribute(const nmc_decoder* decoder, uint32_t index, nmc_attribute* attribute);

/* Colours of all vertices of `level`, in the order of the positions: `component_count` is 3 for red, green, blue or 4
 * for opacity too (255 where the stream has none). Vertex i goes to the bytes from i * stride on. Levels that have not
 * come are interpolated, so every NMC_EVENT_LAYER has colours to show. NMC_ERR_STATE when the stream has no colours or
 * none have come yet. Legal from the first NMC_EVENT_LAYER on. */
NMC_API nmc_status nmc_decoder_read_colors(nmc_decoder* decoder, uint32_t level, uint8_t* colors,
                                           uint32_t component_count, size_t stride, uint32_t vertex_count);

/* All components of any attribute, layout and errors as nmc_decoder_read_colors; the stride is in bytes. */
NMC_API nmc_status nmc_decoder_read_attribute(nmc_decoder* decoder, uint32_t index, uint32_t level, uint16_t* values,
                                              size_t stride, uint32_t vertex_count);

/* Hash of the values of an attribute as coded, at the vertices of `level` (spec 9.4): equal in every decoder. */
NMC_API nmc_status nmc_decoder_attribute_hash(nmc_decoder* decoder, uint32_t index, uint32_t level, uint64_t* hash);

/* ---- proofs and figures ------------------------------------------------------------------------------------------ */

/* Hash of all integers of the current layer (spec 9.1): equal in every conformant decoder. */
NMC_API nmc_status nmc_decoder_state_hash(const nmc_decoder* decoder, uint64_t* hash);

/* Hash of the positions of `level` in double precision (spec 9.2): equal in every decoder that claims exactness. */
NMC_API nmc_status nmc_decoder_position_hash(nmc_decoder* decoder, uint32_t level, uint64_t* hash);

/* Bytes the decoder holds now and the most it has ever held since creation. */
NMC_API nmc_status nmc_decoder_memory(const nmc_decoder* decoder, uint64_t* used, uint64_t* peak);

#ifdef __cplusplus
}
#endif

#endif /* NMC_NMC_H_ */
