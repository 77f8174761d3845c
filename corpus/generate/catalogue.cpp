// SPDX-License-Identifier: Apache-2.0
#include "corpus/generate/shapes.h"

namespace nmc::corpus {

const std::vector<CatalogueEntry>& catalogue() {
  static const std::vector<CatalogueEntry> entries = {
      {"zone_sphere", "waves that outrun the sampling: aliasing, thesis Fig. 3.7",
       [] { return zone_sphere(6); }},
      {"noisy_sphere", "detail that no coder can predict", [] { return noisy_sphere(6); }},
      {"spiky_ball", "extremities that a coarse base mesh starves", [] { return spiky_ball(6); }},
      {"koch", "sharp detail at every scale, thesis Fig. 3.5 on a surface", [] { return koch_surface(5); }},
      {"gear", "flat faces and long creases", [] { return gear(); }},
      {"gyroid", "high genus with curved walls", [] { return gyroid(); }},
      {"genus_100", "topology that costs more than the shape", [] { return perforated_plate(10, 10); }},
      {"comb", "many parallel limbs", [] { return comb(); }},
      {"thin_sheets", "walls closer than a triangle is wide: rays hit the wrong side",
       [] { return thin_sheets(); }},
      {"disk_300_holes", "boundaries that outnumber base vertices", [] { return disk_with_holes(300); }},
      {"long_cylinder", "aspect ratio 1000", [] { return long_cylinder(); }},
      {"torus_knot", "a long knotted tube: large geodesic, small Euclidean distance",
       [] { return torus_knot(); }},
      {"terrain", "a height field with one boundary", [] { return terrain(300); }},
      {"moebius", "cannot be oriented", [] { return moebius_strip(200, 10); }},
      {"klein_bottle", "closed, cannot be oriented, crosses itself", [] { return klein_bottle(160, 60); }},
      {"loose_triangles", "100,000 components", [] { return loose_triangles(100000); }},
  };
  return entries;
}

}  // namespace nmc::corpus
