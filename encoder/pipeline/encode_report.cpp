// SPDX-License-Identifier: Apache-2.0
#include "encoder/pipeline/encode_report.h"

#include <fmt/format.h>
#include <sys/resource.h>

#include <nlohmann/json.hpp>

#include "libnmc/common/format.h"

namespace nmc {

namespace {

const char* target_name(TargetKind kind) {
  switch (kind) {
    case TargetKind::kMaximumError:
      return "maxError";
    case TargetKind::kRmsError:
      return "rmsError";
    case TargetKind::kSize:
      return "size";
  }
  return "";
}

const char* domain_name(DomainChoice domain) {
  switch (domain) {
    case DomainChoice::kGeneral:
      return "general";
    case DomainChoice::kSphere:
      return "sphere";
    case DomainChoice::kInput:
      return "input";
    case DomainChoice::kAuto:
      return "auto";
  }
  return "";
}

}  // namespace

std::uint64_t peak_memory_bytes() {
  rusage usage{};
  if (getrusage(RUSAGE_SELF, &usage) != 0) return 0;
  return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

std::string human_bytes(std::uint64_t bytes) {
  const double b = static_cast<double>(bytes);
  if (bytes < 1000) return fmt::format("{} B", bytes);
  if (bytes < 1'000'000) return fmt::format("{:.2f} kB", b / 1e3);
  if (bytes < 1'000'000'000) return fmt::format("{:.2f} MB", b / 1e6);
  return fmt::format("{:.2f} GB", b / 1e9);
}

std::string report_json(const EncodeResult& result, const ReportContext& context) {
  using nlohmann::json;
  json j;
  j["schema"] = "nmc-encode-v1";
  j["input"] = {{"file", context.input_name},
                {"bytes", context.input_bytes},
                {"vertices", result.condition.input_vertices},
                {"triangles", result.condition.input_triangles},
                {"droppedProperties", context.dropped_properties}};
  j["diagonal"] = result.diagonal;
  j["condition"] = json::parse(to_json(result.condition));
  j["components"] = result.condition.components.size();
  j["genus"] = result.condition.total_genus();
  j["domain"] = domain_name(result.domain);
  j["base"] = {{"vertices", result.candidate.base_vertex_count},
               {"triangles", result.candidate.base_face_count},
               {"bytes", result.stream.base_size}};
  j["levels"] = result.level_count;
  j["nonNormal"] = {{"count", result.candidate.non_normal_count},
                    {"of", result.candidate.odd_vertex_count},
                    {"share", result.candidate.odd_vertex_count
                                  ? static_cast<double>(result.candidate.non_normal_count) /
                                        static_cast<double>(result.candidate.odd_vertex_count)
                                  : 0.0}};
  j["flippedTriangles"] = result.folded_triangle_count;
  j["bytes"] = result.stream.bytes.size();
  j["headerBytes"] = result.stream.header_size;
  if (result.colors) {
    j["colors"] = {{"bytes", result.stream.color_size},
                   {"psnrDb", result.colors->psnr_db},
                   {"resolutionPsnrDb", result.colors->resolution_psnr_db},
                   {"level", result.colors->finest_level},
                   {"vertices", result.colors->vertex_count},
                   {"lumaStep", result.colors->luma_step},
                   {"met", result.colors->is_met}};
  }
  const double vertices = static_cast<double>(result.condition.input_vertices);
  j["bitsPerVertex"] = vertices > 0 ? 8 * static_cast<double>(result.stream.bytes.size()) / vertices : 0.0;
  j["rmsError"] = result.error.rms;
  j["maxError"] = result.error.maximum;
  j["relativeRmsError"] = result.error.rms / result.diagonal;
  j["relativeMaxError"] = result.error.maximum / result.diagonal;
  j["target"] = {
      {"kind", target_name(context.target.kind)}, {"value", context.target.value}, {"met", result.target_met}};
  json layers = json::array();
  for (const StreamRow& row : result.stream.rows) {
    layers.push_back({{"endByte", row.end_offset},
                      {"level", row.level},
                      {"triangles", row.triangle_count},
                      {"rmsError", row.error.rms},
                      {"maxError", row.error.maximum}});
  }
  j["layers"] = layers;
  json attempts = json::array();
  for (const EncodeResult::Attempt& a : result.attempts) {
    attempts.push_back({{"baseVertices", a.base_vertex_count},
                        {"levels", a.level_count},
                        {"step", a.normal_step},
                        {"bytes", a.byte_count},
                        {"rmsError", a.error.rms},
                        {"maxError", a.error.maximum}});
  }
  j["attempts"] = attempts;
  json times;
  for (const StageTime& t : result.times) times[t.stage] = t.seconds;
  times["total"] = context.seconds;
  j["seconds"] = times;
  j["threads"] = context.thread_count;
  j["peakMemoryBytes"] = peak_memory_bytes();
  j["stateHash"] = fmt::format("{:016x}", result.stream.state_hash);
  j["positionHash"] = fmt::format("{:016x}", result.stream.position_hash);
  return j.dump(2) + "\n";
}

std::string summary_line(const EncodeResult& result, const ReportContext& context) {
  const auto bytes = static_cast<double>(result.stream.bytes.size());
  const double ratio = bytes > 0 ? static_cast<double>(context.input_bytes) / bytes : 0;
  const double vertices = static_cast<double>(result.condition.input_vertices);
  std::string line = fmt::format("{} {} -> {} {}", context.input_name, human_bytes(context.input_bytes),
                                 context.output_name, human_bytes(result.stream.bytes.size()));
  line += fmt::format(" (1/{:.0f}, {:.3g} bit/vertex)", ratio, vertices > 0 ? 8 * bytes / vertices : 0.0);
  line += fmt::format(", max error {:.4g} ({:.3g} % of the diagonal), RMS {:.4g} ({:.3g} %)", result.error.maximum,
                      100 * result.error.maximum / result.diagonal, result.error.rms,
                      100 * result.error.rms / result.diagonal);
  if (context.target.kind == TargetKind::kSize)
    line += fmt::format(" [asked: {}]", human_bytes(static_cast<std::uint64_t>(context.target.value)));
  else
    line += fmt::format(" [asked: {} {:.4g}]",
                        context.target.kind == TargetKind::kRmsError ? "RMS" : "max", context.target.value);
  if (result.colors)
    line += fmt::format(", colours {:.1f} dB in {}", result.colors->psnr_db, human_bytes(result.stream.color_size));
  line += fmt::format(", first mesh at {}", human_bytes(result.stream.rows.front().end_offset));
  line += fmt::format(", {:.1f} s", context.seconds);
  return line;
}

}  // namespace nmc
