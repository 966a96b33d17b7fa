// SPDX-License-Identifier: Apache-2.0
#include <Interface_EntityIterator.hxx>
#include <Interface_Graph.hxx>
#include <Interface_Static.hxx>
#include <STEPConstruct.hxx>
#include <STEPConstruct_Styles.hxx>
#include <STEPControl_Reader.hxx>
#include <StepBasic_Product.hxx>
#include <StepBasic_ProductDefinition.hxx>
#include <StepBasic_ProductDefinitionFormation.hxx>
#include <StepRepr_NextAssemblyUsageOccurrence.hxx>
#include <StepRepr_ProductDefinitionShape.hxx>
#include <StepRepr_RepresentationRelationship.hxx>
#include <StepShape_ShapeDefinitionRepresentation.hxx>
#include <StepShape_ShapeRepresentation.hxx>
#include <StepShape_SolidModel.hxx>
#include <StepVisual_Colour.hxx>
#include <StepVisual_StyledItem.hxx>
#include <TColStd_SequenceOfAsciiString.hxx>
#include <TopExp_Explorer.hxx>
#include <TransferBRep.hxx>
#include <Transfer_TransientProcess.hxx>
#include <XSControl_TransferReader.hxx>
#include <XSControl_WorkSession.hxx>
#include <map>
#include <vector>

#include "master/import/cad/document.h"
#include "master/import/cad/shape_tree.h"
#include "master/import/crash_line.h"

namespace tessera::import::cad {
namespace {

struct Unit {
  const char* in_file;  // upper case
  const char* static_name;
  double millimetres;
};
constexpr Unit kUnits[] = {{"MILLIMETRE", "MM", 1},    {"CENTIMETRE", "CM", 10},
                           {"METRE", "M", 1000},       {"KILOMETRE", "KM", 1e6},
                           {"MICROMETRE", "UM", 1e-3}, {"INCH", "INCH", 25.4},
                           {"FOOT", "FT", 304.8},      {"MILE", "MI", 1609344}};

// Lengths stay in the file's unit: Open CASCADE would make millimetres of them.
std::string keep_unit(STEPControl_Reader& reader) {
  TColStd_SequenceOfAsciiString lengths, angles, solid_angles;
  reader.FileUnits(lengths, angles, solid_angles);
  if (lengths.IsEmpty()) return "MM";
  TCollection_AsciiString name = lengths.First();
  name.UpperCase();
  for (const Unit& unit : kUnits) {
    if (name != unit.in_file) continue;
    Interface_Static::SetCVal("xstep.cascade.unit", unit.static_name);
    reader.SetSystemLengthUnit(unit.millimetres);
    return unit.static_name;
  }
  return "MM";
}

// The product whose shape a representation is; by way of one relationship at most.
std::string product_name(const Interface_Graph& graph, const Handle(Standard_Transient) & part,
                         int depth) {
  Interface_EntityIterator users = graph.Sharings(part);
  for (users.Start(); users.More(); users.Next()) {
    const Handle(Standard_Transient) user = users.Value();
    if (const auto s = Handle(StepShape_ShapeDefinitionRepresentation)::DownCast(user)) {
      const auto shape = Handle(StepRepr_PropertyDefinition)::DownCast(s->Definition().Value());
      if (shape.IsNull()) continue;
      const auto definition = shape->Definition().ProductDefinition();
      if (definition.IsNull() || definition->Formation().IsNull()) continue;
      const auto product = definition->Formation()->OfProduct();
      if (!product.IsNull() && !product->Name().IsNull()) return product->Name()->ToCString();
    }
    if (depth > 0 && (user->IsKind(STANDARD_TYPE(StepShape_ShapeRepresentation)) ||
                      user->IsKind(STANDARD_TYPE(StepRepr_RepresentationRelationship)))) {
      if (const std::string name = product_name(graph, user, depth - 1); !name.empty()) return name;
    }
    if (const auto r = Handle(StepRepr_RepresentationRelationship)::DownCast(user);
        depth > 0 && !r.IsNull()) {
      for (const auto& end : {r->Rep1(), r->Rep2()}) {
        if (end.IsNull() || end == part) continue;
        if (const std::string name = product_name(graph, end, depth - 2); !name.empty())
          return name;
      }
    }
  }
  return {};
}

void add_names(const Handle(XSControl_WorkSession) & session, Document& document) {
  const Interface_Graph graph(session->Model());
  const Handle(Transfer_TransientProcess) process = session->TransferReader()->TransientProcess();
  std::map<const TopoDS_TShape*, std::string> names;
  for (int i = 1; i <= session->Model()->NbEntities(); ++i) {
    const auto item = Handle(StepShape_SolidModel)::DownCast(session->Model()->Value(i));
    if (item.IsNull()) continue;
    const TopoDS_Shape shape = TransferBRep::ShapeResult(process, item);
    if (shape.IsNull()) continue;
    std::string name = product_name(graph, item, 2);
    if (name.empty() && !item->Name().IsNull()) name = item->Name()->ToCString();
    for (TopExp_Explorer solid(shape, TopAbs_SOLID); solid.More(); solid.Next())
      names[solid.Current().TShape().get()] = name;
  }
  for (Part& part : document.parts)
    if (const auto it = names.find(part.shape.TShape().get()); it != names.end())
      part.name = it->second;
}

void add_colors(const Handle(XSControl_WorkSession) & session, Document& document) {
  STEPConstruct_Styles styles(session);
  if (!styles.LoadStyles()) return;
  const Handle(Transfer_TransientProcess) process = session->TransferReader()->TransientProcess();
  for (int i = 1; i <= styles.NbStyles(); ++i) {
    const Handle(StepVisual_StyledItem) style = styles.Style(i);
    Handle(StepVisual_Colour) surface, boundary, curve, rendering;
    double transparency = 0;
    bool is_component = false;
    if (style.IsNull() ||
        !styles.GetColors(style, surface, boundary, curve, rendering, transparency, is_component))
      continue;
    const Handle(StepVisual_Colour) chosen = surface.IsNull() ? rendering : surface;
    Quantity_Color color;
    if (chosen.IsNull() || style->Item().IsNull() ||
        !STEPConstruct_Styles::DecodeColor(chosen, color))
      continue;
    const TopoDS_Shape shape = STEPConstruct::FindShape(process, style->Item());
    if (!shape.IsNull()) document.colors.emplace(shape.TShape().get(), color);
  }
}

// Whether no product is an assembly that it is a part of, by way of others or not.
Status check_assemblies(const std::string& path, const Handle(Interface_InterfaceModel) & model) {
  std::multimap<int, int> parts;    // assembly, part
  std::map<int, int> usage_counts;  // of each product
  for (int i = 1; i <= model->NbEntities(); ++i) {
    const auto usage = Handle(StepRepr_NextAssemblyUsageOccurrence)::DownCast(model->Value(i));
    if (usage.IsNull()) continue;
    const int whole = model->Number(usage->RelatingProductDefinition());
    const int part = model->Number(usage->RelatedProductDefinition());
    parts.emplace(whole, part);
    usage_counts.try_emplace(whole, 0);
    ++usage_counts[part];
  }
  std::vector<int> roots;  // whose usages are all accounted for
  for (const auto& [product, count] : usage_counts)
    if (count == 0) roots.push_back(product);
  std::size_t done = 0;
  for (; done < roots.size(); ++done) {
    const auto [begin, end] = parts.equal_range(roots[done]);
    for (auto it = begin; it != end; ++it)
      if (--usage_counts[it->second] == 0) roots.push_back(it->second);
  }
  if (done == usage_counts.size()) return Status::ok();
  return Status::invalid_argument(path + ": an assembly is a part of itself by way of others");
}

}  // namespace

Result<Document> read_step(const std::string& path) {
  TESSERA_RETURN_IF_ERROR(check_end(path, {"END-ISO-10303-21"}));
  STEPControl_Reader reader;
  if (reader.ReadFile(path.c_str()) != IFSelect_RetDone || reader.Model().IsNull())
    return Status::invalid_argument(path + ": is damaged: not readable as STEP");
  if (reader.Model()->NbEntities() == 0) return no_surfaces(path, {});
  if (const std::string damage = first_damage(reader.Model()); !damage.empty())
    CrashLine::note(damage);
  TESSERA_RETURN_IF_ERROR(check_circles(path, reader.Model()));
  TESSERA_RETURN_IF_ERROR(check_assemblies(path, reader.Model()));
  Document document;
  document.unit = keep_unit(reader);
  reader.TransferRoots();
  const TopoDS_Shape shape = reader.NbShapes() > 0 ? reader.OneShape() : TopoDS_Shape();
  if (!shape.IsNull()) add_parts(shape, document);
  if (document.parts.empty()) return no_surfaces(path, shape);
  add_names(reader.WS(), document);
  add_colors(reader.WS(), document);
  return document;
}

std::optional<Quantity_Color> Document::color_of(const TopoDS_Shape& shape) const {
  const auto it = colors.find(shape.TShape().get());
  return it == colors.end() ? std::nullopt : std::optional(it->second);
}

}  // namespace tessera::import::cad
