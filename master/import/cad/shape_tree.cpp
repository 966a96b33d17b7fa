// SPDX-License-Identifier: Apache-2.0
#include "master/import/cad/shape_tree.h"

#include <BRep_Builder.hxx>
#include <Interface_Check.hxx>
#include <Interface_EntityIterator.hxx>
#include <Interface_Graph.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS_Compound.hxx>
#include <TopoDS_Iterator.hxx>
#include <fstream>
#include <initializer_list>
#include <vector>

namespace tessera::import::cad {
namespace {

constexpr int kEndBytes = 4096;
constexpr std::size_t kDepthMax = 10'000;

void add_part(const TopoDS_Shape& part, const void* key, const TopLoc_Location& place,
              std::map<const void*, std::size_t>& known, Document& document) {
  const auto [at, is_new] = known.try_emplace(key, document.parts.size());
  if (is_new) document.parts.push_back({part, {}});
  document.placements.push_back({at->second, place.Transformation()});
}

void walk(const TopoDS_Shape& shape, const TopLoc_Location& above,
          std::map<const void*, std::size_t>& known, Document& document) {
  const TopLoc_Location place = above * shape.Location();
  const TopoDS_Shape here = shape.Located(TopLoc_Location());
  if (shape.ShapeType() != TopAbs_COMPOUND) {
    if (TopExp_Explorer(here, TopAbs_FACE).More())
      add_part(here, here.TShape().get(), place, known, document);
    return;
  }
  TopoDS_Compound loose;
  BRep_Builder().MakeCompound(loose);
  bool is_any = false;
  for (TopoDS_Iterator child(here); child.More(); child.Next()) {
    if (child.Value().ShapeType() <= TopAbs_SOLID) {
      walk(child.Value(), place, known, document);
    } else if (TopExp_Explorer(child.Value(), TopAbs_FACE).More()) {
      BRep_Builder().Add(loose, child.Value());
      is_any = true;
    }
  }
  if (is_any) add_part(loose, here.TShape().get(), place, known, document);
}

}  // namespace

Status check_end(const std::string& path, std::initializer_list<const char*> end_marks) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  const auto size = static_cast<std::streamoff>(file.tellg());
  if (size < 0) return Status::not_found(path + ": cannot be opened");
  file.seekg(size > kEndBytes ? size - kEndBytes : 0);
  std::string end(static_cast<std::size_t>(size > kEndBytes ? kEndBytes : size), '\0');
  file.read(end.data(), static_cast<std::streamsize>(end.size()));
  for (const char* mark : end_marks)
    if (end.find(mark) != end.npos) return Status::ok();
  return Status::invalid_argument(path + ": is cut off: its end is missing");
}

Status check_circles(const std::string& path, const Handle(Interface_InterfaceModel) & model) {
  const Interface_Graph graph(model);
  enum class Mark : unsigned char { kNew, kOpen, kDone };
  std::vector<Mark> marks(static_cast<std::size_t>(model->NbEntities()) + 1, Mark::kNew);
  struct Level {
    int entity;
    Interface_EntityIterator shared;
  };
  for (int first = 1; first <= model->NbEntities(); ++first) {
    if (marks[static_cast<std::size_t>(first)] != Mark::kNew) continue;
    std::vector<Level> levels;
    const auto enter = [&](int entity) {
      marks[static_cast<std::size_t>(entity)] = Mark::kOpen;
      levels.push_back({entity, graph.Shareds(model->Value(entity))});
      levels.back().shared.Start();
    };
    enter(first);
    while (!levels.empty()) {
      Level& level = levels.back();
      if (!level.shared.More()) {
        marks[static_cast<std::size_t>(level.entity)] = Mark::kDone;
        levels.pop_back();
        continue;
      }
      const int next = model->Number(level.shared.Value());
      level.shared.Next();
      if (next <= 0 || marks[static_cast<std::size_t>(next)] == Mark::kDone) continue;
      if (marks[static_cast<std::size_t>(next)] == Mark::kOpen || levels.size() >= kDepthMax) {
        const Handle(TCollection_HAsciiString) label = model->StringLabel(model->Value(next));
        return Status::invalid_argument(path + ": entity " + label->ToCString() +
                                        " refers to itself by way of others");
      }
      enter(next);
    }
  }
  return Status::ok();
}

void add_parts(const TopoDS_Shape& shape, Document& document) {
  std::map<const void*, std::size_t> known;
  walk(shape, TopLoc_Location(), known, document);
}

std::string first_damage(const Handle(Interface_InterfaceModel) & model) {
  for (int i = 1; i <= model->NbEntities(); ++i) {
    const Handle(Interface_Check) check = model->Check(i, true);
    if (check.IsNull() || !check->HasFailed()) continue;
    return std::string("entity ") + model->StringLabel(model->Value(i))->ToCString() +
           " is damaged: " + check->CFail(1);
  }
  return {};
}

Status no_surfaces(const std::string& path, const TopoDS_Shape& shape) {
  TopTools_IndexedMapOfShape edges;
  if (!shape.IsNull()) TopExp::MapShapes(shape, TopAbs_EDGE, edges);
  return Status::invalid_argument(
      path + ": no surfaces" +
      (edges.Extent() > 0 ? ", only " + std::to_string(edges.Extent()) + " curves" : ""));
}

}  // namespace tessera::import::cad
