// SPDX-License-Identifier: Apache-2.0
// What a user can ask of the encoder.
#ifndef NMC_ENCODER_PIPELINE_ENCODE_OPTIONS_H_
#define NMC_ENCODER_PIPELINE_ENCODE_OPTIONS_H_

#include <cstdint>
#include <memory>
#include <optional>

#include "encoder/condition/condition.h"
#include "encoder/core/progress.h"
#include "encoder/core/triangle_mesh.h"
#include "libnmc/common/format.h"

namespace nmc {

/// What the file is made for. Errors are symmetric distances to the input.
enum class TargetKind {
  kMaximumError,  // in units of the input
  kRmsError,      // in units of the input
  kSize,          // in bytes
};

struct Target {
  TargetKind kind = TargetKind::kMaximumError;
  double value = 0;
};

/// What the surface is mapped to.
enum class DomainChoice {
  kGeneral,  // a base mesh of the surface's own topology
  kSphere,   // closed surfaces of genus 0 only: the thesis's sphere, with an icosahedron or a mesh as the base
  kInput,    // the input's own base mesh, where it is one with all triangles split 4, 16, 64 ... times
  kAuto,     // general, and the sphere and the input's own base mesh where they exist and take fewer bytes
};

struct EncodeOptions {
  Target target;
  int effort = 5;                       // 1 ... 9
  std::optional<int> base_vertex_count; // default: chosen by cost
  std::optional<int> level_count;       // default: chosen by cost
  DomainChoice domain = DomainChoice::kGeneral;
  /// With kInput: the base mesh, in the input's coordinates; the input is this with all triangles split level_count
  /// times, or as often as its triangles say. Nothing: found from the input's connectivity.
  std::shared_ptr<const TriangleMesh> base_mesh;
  int quality_layer_count = 1;          // 1: smallest file; more: better prefixes
  int region_count = 0;                 // parts that can be fetched and refined alone; 0: none
  double crease_angle_degrees = 0;      // 0: no creases
  /// Wanted peak signal-to-noise ratio of the colours in dB, where the input has any; nothing: no colours.
  std::optional<double> color_psnr_db = 38;
  ConditionOptions condition;
  Units units = Units::kUnknown;
  UpAxis up_axis = UpAxis::kUnknown;
  Progress progress;
};

}  // namespace nmc

#endif  // NMC_ENCODER_PIPELINE_ENCODE_OPTIONS_H_
