// SPDX-License-Identifier: Apache-2.0
#include "clean/params.hpp"

namespace scanmill::clean {
namespace {

void check_box(const Box& box, const std::string& name, std::vector<std::string>& out) {
  if (!is_finite(box.low) || !is_finite(box.high))
    out.push_back(name + ": min and max must be finite");
  else if (!(box.low.x < box.high.x && box.low.y < box.high.y && box.low.z < box.high.z))
    out.push_back(name + ": min must be below max on each axis; the box holds nothing");
}

void check_plane(const PlaneRule& rule, std::vector<std::string>& out) {
  for (const std::string& problem : problems_of(PlaneRule::fields(), &rule)) out.push_back("remove_plane." + problem);
  if (!rule.fit && !(rule.point && rule.normal))
    out.push_back("remove_plane: wanted fit: true, or point and normal of the plane");
  if (rule.fit && rule.point) out.push_back("remove_plane: found fit and point; they exclude each other: keep one");
  if (rule.point && !is_finite(*rule.point)) out.push_back("remove_plane.point: must be finite");
  if (rule.normal && !(is_finite(*rule.normal) && norm2(*rule.normal) > 0 && norm2(*rule.normal) < 1e300))
    out.push_back("remove_plane.normal: must be a direction, not zero");
}

}  // namespace

std::span<const Field> PlaneRule::fields() {
  using P = PlaneRule;
  static const Field kTable[] = {
      field<P, &P::fit>("fit", "", "Find the plane that holds most points; otherwise point and normal give it."),
      field<P, &P::distance_mm>("distance_mm", "", "Points nearer to the plane are removed, mm; must be given.",
                                {0, 1e6, true}),
      field<P, &P::below>("below", "",
                          "Remove everything under the plane too: against its normal, or on the side of a fitted "
                          "plane that holds fewer points."),
      field<P, &P::min_share>("min_share", "", "A fitted plane that holds a smaller share of the points is refused.",
                              {0, 1}),
      field<P, &P::max_tilt_deg>("max_tilt_deg", "", "Greatest angle of a fitted plane from normal, where it is given.",
                                 {0, 90}),
  };
  return kTable;
}

std::span<const Field> StatisticalRule::fields() {
  using P = StatisticalRule;
  static const Field kTable[] = {
      field<P, &P::neighbours>("neighbours", "", "How many other points count as a point's neighbours.", {1, 1e6}),
      field<P, &P::deviations>("deviations", "",
                               "Remove points whose neighbours are farther than the mean by more than this many "
                               "standard deviations.",
                               {0, 100}),
  };
  return kTable;
}

std::span<const Field> OutlierRules::fields() {
  using P = OutlierRules;
  static const Field kTable[] = {
      field<P, &P::min_component_points>("min_component_points", "",
                                         "Remove connected pieces of the cloud with fewer points.", {1, 1e12}),
      field<P, &P::min_component_share>("min_component_share", "",
                                        "Remove connected pieces with a smaller share of the points.", {0, 1}),
      field<P, &P::component_range_bins>("component_range_bins", "",
                                         "Bins this near to each other, on each axis, belong to one piece.", {1, 8}),
      field<P, &P::bin_mm>("bin_mm", "",
                           "Edge of the bins that the outlier rules work on, mm; lattice.bin_mm unless given.",
                           {0, 1e6, true}),
  };
  return kTable;
}

std::vector<std::string> Params::problems() const {
  std::vector<std::string> out;
  if (keep_box) check_box(*keep_box, "keep_box", out);
  for (const Box& box : remove_box) check_box(box, "remove_box", out);
  if (remove_plane) check_plane(*remove_plane, out);
  if (!outliers) return out;
  for (const std::string& problem : problems_of(OutlierRules::fields(), &*outliers))
    out.push_back("outliers." + problem);
  if (outliers->statistical)
    for (const std::string& problem : problems_of(StatisticalRule::fields(), &*outliers->statistical))
      out.push_back("outliers.statistical." + problem);
  if (!outliers->any())
    out.push_back("outliers: wanted at least one of statistical, min_component_points, min_component_share");
  return out;
}

}  // namespace scanmill::clean
