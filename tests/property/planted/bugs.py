# SPDX-License-Identifier: Apache-2.0
"""Bugs to plant in the core, such as people write by mistake.

Each has a file under slave/core, the text that stands there once, what stands there instead, and a test that is
tried first. An expression is replaced by an expression, a statement (it ends with a semicolon) by a statement.
"""
import dataclasses


@dataclasses.dataclass(frozen=True)
class Bug:
    name: str
    what: str   # what was done
    file: str   # path under slave/core
    right: str
    wrong: str
    first: str  # a pattern of tests' names; all others of the label follow


BUGS = (
    # One ray and its boxes.
    Bug("slab_slack", "boxes of one ray have no room for rounding", "traverse/ray_slabs-inl.h",
        "reach * abs(inverse) * (8 * kRoundoff)", "reach * 0.0f", "core_hard_cases"),
    Bug("flat_axis", "a ray that hardly moves along an axis gets no padding", "ray/one_ray-inl.h",
        "hn::IfThenElseZero(is_flat, widest)", "hn::Zero(d)", "core_hard_cases"),
    Bug("scale_lost", "long and short directions are not scaled", "ray/one_ray-inl.h",
        "largest > wanted * 0x1p-20f && largest < wanted * 0x1p20f", "largest > 0", "core_watertight"),
    Bug("tie_rule", "at one t the later triangle wins", "ray/one_ray-inl.h",
        "t == best_t && is_lower", "t == best_t", "core_companions"),
    Bug("begin_ignored", "hits before t_min count", "ray/one_ray-inl.h",
        "t >= t_min", "true", "core_kernels"),
    Bug("any_stops_late", "a far leaf is left out of an any-hit search", "traverse/node_stack-inl.h",
        "entries_[size_++] = {child, -__builtin_inff()};",
        "if (size_ % 7 != 6) entries_[size_++] = {child, -__builtin_inff()};", "core_kernels"),
    # Packets.
    Bug("frustum_slack", "the planes of a fan are moved in by what they may be off", "ray/fan_rays-inl.h",
        "bound + sign * abs_of(bound) * (8 * kRoundoff)", "bound - sign * abs_of(bound) * (8 * kRoundoff)",
        "core_hard_cases"),
    Bug("packet_tie_rule", "at one t a packet keeps the triangle that came first", "ray/bundle_rays-inl.h",
        "test.t < old_t || (test.t == old_t && is_lower)", "test.t < old_t", "core_hard_cases"),
    Bug("row_skipped", "the last row of a bundle is not tested", "primitive/triangle/triangle_bundle-inl.h",
        "rows |= uint64_t{bits_of<VR>(keep)} << first;",
        "rows |= (uint64_t{bits_of<VR>(keep)} << first) & ~(uint64_t{1} << (kRows - 1));", "core_hard_cases"),
    Bug("depth_too_near", "a row's depth takes its nearest ray", "ray/bundle_rays-inl.h",
        "row_far[row] = greatest_lane(depths(row)) * (1 + kTimeSlack);",
        "row_far[row] = least_lane(depths(row)) * (1 + kTimeSlack);", "core_hard_cases"),
    Bug("window_narrow", "the frustum of a window of pixels has lost its far side", "traverse/entry-inl.h",
        "f.slope_u[1] = outward(window.high[0], 1);", "f.slope_u[1] = outward(window.low[0], 1);", "core_entry"),
    # Triangles.
    Bug("edge_swapped", "one edge of a triangle runs the other way", "primitive/triangle/triangle_ray-inl.h",
        "edge_of(2, 0)", "edge_of(0, 2)", "core_kernels"),
    Bug("open_hull", "what passes through an edge misses", "primitive/triangle/exact_hit.cpp",
        "is_left = is_left || side < 0;", "is_left = is_left || side <= 0;", "core_watertight"),
    Bug("rounded_sign", "an exact sum forgets what was rounded off", "primitive/triangle/exact_hit.cpp",
        "if (sum.low != 0) parts_[kept++] = sum.low;", ";", "core_exact_hit"),
    Bug("fan_tolerance", "a fan's edges have no tolerance", "primitive/triangle/fan_forms-inl.h",
        "mul_add(Tests::largest(over[0], over[1], over[2]), set<VB>(kUnderflow), tolerance_ * p.size)",
        "0.0f * p.size", "core_hard_cases"),
    Bug("back_faces", "a fan takes each triangle for one that faces it", "primitive/triangle/fan_forms-inl.h",
        "bit_cast<UintOf<VB>>(volume) & 0x80000000u", "bit_cast<UintOf<VB>>(volume) & 0u", "core_kernels"),
    Bug("nearness_sure", "a fan takes a computed nearness for exact", "primitive/triangle/fan_forms-inl.h",
        "g * mul_add(h, set<VB>(15 * kRoundoff), set<VB>(17 * kRoundoff)) + kUnderflow", "0.0f * (g + h)",
        "core_fan_triangles"),
    Bug("end_at_zero", "a hit at t = 0 hides the others at 0", "ray/fan_rays-inl.h",
        "min_of(near * (1 - kNearSlack) - kUnderflow, kNearMax)", "near * (1 - kNearSlack) - kUnderflow",
        "core_kernels"),
    Bug("winner_unsettled", "a ray in doubt compares with a t that is not its own",
        "primitive/triangle/triangle_fan-inl.h", "if (!kAny) winners_.settle(number[i]);", ";", "core_fan_triangles"),
    Bug("sides_too_sure", "double's word is taken for an edge that it cannot tell", "primitive/triangle/edge_sides-inl.h",
        "abs(value) > size * kDeterminantError", "abs(value) > -size", "core_fan_triangles"),
    Bug("bad_ray_in_fan", "a shadow fan takes a ray in whose projection is no number", "ray/fan_rays-inl.h",
        "if (!is_none<V>(and_not(is_within, is_valid))) return false;", ";", "core_shadow_fans"),
    Bug("thin_unseen", "slivers whose side is unsure are taken for sure", "primitive/triangle/fan_forms-inl.h",
        "is_good && abs(volume) * 0.75f > thin * p.size", "is_good", "core_fan_triangles"),
    Bug("elsewhere_sure", "a ray is said to miss a triangle by less than its t is known", "primitive/triangle/elsewhere-inl.h",
        "off * 2 + 8 * 0x1p-53", "off * -2 - 8 * 0x1p-53", "core_sliver_answers"),
    Bug("elsewhere_never", "open triangles are decided without a look at their planes", "primitive/triangle/triangle_ray-inl.h",
        "__builtin_popcount(open) > kFew", "__builtin_popcount(open) > 99", "core_flat_mesh"),
    Bug("ray_tolerance", "the edges of one ray have no tolerance", "primitive/triangle/triangle_ray-inl.h",
        "kEdgeTolerance * ray_.reach", "0.0f * ray_.reach", "core_sliver_answers"),
    Bug("bundle_tolerance", "a bundle's edges have no tolerance", "primitive/triangle/triangle_bundle-inl.h",
        "kEdgeTolerance * (size_[lane] + rays_.reach)", "0.0f * (size_[lane] + rays_.reach)", "core_sliver_answers"),
    Bug("plane_met", "a ray in the plane of a triangle meets it", "primitive/triangle/exact_hit.cpp",
        "return is_left || is_right;", "return true;", "core_exact_hit"),
    Bug("flight_t", "a ray in flight that misses has its last t", "traverse/bvh_flight-inl.h",
        "has_hit ? ray.best_t : 0", "ray.best_t", "core_sliver_answers"),
    Bug("steepness_low", "t of a plane counts where its digits have cancelled", "primitive/triangle/plane-inl.h",
        "size * plane.scale * 0x1p-24", "size * plane.scale * 0x1p-60", "core_sliver_answers"),
    Bug("excluded_met", "a shadow ray meets the triangle that it ends on", "primitive/triangle/triangle_ray-inl.h",
        "is_other(ray_.excluded[0]) && is_other(ray_.excluded[1])", "is_other(ray_.excluded[0])", "core_gather"),
    Bug("plane_turned", "the normal of a plane has a wrong sign on one axis", "primitive/triangle/plane-inl.h",
        "(zx - xz) * plane.scale", "(xz - zx) * plane.scale", "core_kernels"),
    # Structures.
    Bug("leaf_cut", "a full block of a leaf loses its last triangle", "primitive/triangle/triangle_writer.cpp",
        "first + lane < primitives.size()", "first + lane < primitives.size() && lane + 1 < W", "core_bvh"),
    Bug("kd_sides", "a ray that goes down takes the lower child first", "traverse/kd-inl.h",
        "ray_.is_down(axis) ? lower + 1 : lower", "lower", "core_hard_cases"),
    Bug("kd_slack", "no room for rounding at a kd-tree's planes", "traverse/kd-inl.h",
        "abs_of(t) * (8 * kRoundoff) + ray_.pad[axis]", "0.0f", "core_hard_cases"),
    Bug("clip_inward", "boxes of clipped triangles are rounded inwards", "primitive/triangle/triangle_clipper.cpp",
        "is_inside ? std::nextafter(rounded, towards) : rounded",
        "is_inside ? rounded : std::nextafter(rounded, -towards)", "core_kernels"),
    Bug("across_lost", "what lies across a plane of the kd-tree is below it alone", "accel/kd_builder.cpp",
        "if (!is_there[side]) continue;", "if (!is_there[side] || (side == 1 && is_there[0])) continue;", "core_kd_tree"),
    # Instances.
    Bug("transposed", "an instance's matrix is read by columns", "primitive/instance/instance_leaf-inl.h",
        "row[0] * x + row[1] * y", "row[0] * x + instance.to_world[1][a == 0 ? 0 : 1] * y", "core_instances"),
    Bug("pad_forgotten", "a ray's place in object space is taken for exact", "primitive/instance/instance_leaf-inl.h",
        "instance.pad[a] + kPlacedOriginError * ray.origin_size[a]", "0.0f", "core_instances"),
    Bug("number_kept", "a triangle of an instance has its number in the mesh", "primitive/instance/instance_leaf-inl.h",
        "number + instance.first_primitive", "number", "core_instances"),
    Bug("placed_box", "the box of a turned instance is that of two corners", "primitive/instance/instance_placement.cpp",
        "low += std::min(p, q);", "low += p;", "core_instances"),
    Bug("moved_unseen", "boxes above a moved instance do not grow", "primitive/instance/top_edit.cpp",
        "set_box(slot, united(box_at(slot), box));", "set_box(slot, box_at(slot));", "core_moved_instances"),
    Bug("left_behind", "a moved instance stays in its leaf, too", "primitive/instance/top_edit.cpp",
        "count == 1 ? kBvhNoChild : leaf_with(first, count - 1)", "leaf", "core_moved_instances"),
    Bug("farthest_kept", "who lay farthest is taken to lie there still", "primitive/instance/exact_bounds.cpp",
        "known != nullptr && !std::binary_search(changed.begin(), changed.end(), who)", "known != nullptr",
        "core_moved_instances"),
    Bug("flat_part_kept", "what is flattened is taken for the same wherever it stands", "scene/prepared_scene.cpp",
        "known.index->flat->made_of == flattened.part.made_of",
        "known.index->flat->made_of.size() == flattened.part.made_of.size()", "core_moved_instances"),
    # Surfaces, light and chance.
    Bug("coordinates_equal", "u of a hit is its v", "primitive/triangle/barycentric-inl.h",
        "dot(from_, p)", "dot(direction, across_)", "core_light_classes"),
    Bug("offset_short", "a ray leaves its surface from within its rounding", "surface/surface_point-inl.h",
        "dot(abs(normal), error) + 16 * kRoundoff * reach", "dot(abs(normal), error) * 0.01f", "core_surfaces"),
    Bug("shadowing_half", "hiding from the viewer and from the light are taken for independent", "bsdf/microfacet-inl.h",
        "z_light * (z_viewer + root_viewer) / (root_viewer * z_light + root_light * z_viewer)",
        "2 * z_light / (z_light + root_light)", "core_bsdf_test"),
    Bug("pdf_of_half", "the pdf of a reflected direction is that of its half vector", "bsdf/glossy-inl.h",
        "facets_share_ * distribution / (2 * (viewer_.z + root_viewer))",
        "facets_share_ * distribution / (viewer_.z + root_viewer)", "core_bsdf_packets"),
    Bug("sky_shifted", "the sky's picture is looked up half a column off", "light/sky-inl.h",
        "place.x - 0.5f", "place.x", "core_sky_test"),
    Bug("sky_pdf", "the pdf of the sky forgets that rows near the poles are narrow", "light/sky-inl.h",
        "kTwoPi2 * polar.sin / chance", "kTwoPi2 / chance", "core_sky_test"),
)
