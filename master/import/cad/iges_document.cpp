// SPDX-License-Identifier: Apache-2.0
#include <BRepBndLib.hxx>
#include <BRepBuilderAPI_Sewing.hxx>
#include <BRep_Tool.hxx>
#include <Bnd_Box.hxx>
#include <IGESControl_Reader.hxx>
#include <IGESData_ColorEntity.hxx>
#include <IGESData_GlobalSection.hxx>
#include <IGESData_IGESEntity.hxx>
#include <IGESData_IGESModel.hxx>
#include <IGESGraph_Color.hxx>
#include <Interface_Static.hxx>
#include <TopExp_Explorer.hxx>
#include <TransferBRep.hxx>
#include <Transfer_TransientProcess.hxx>
#include <XSControl_TransferReader.hxx>
#include <XSControl_WorkSession.hxx>
#include <algorithm>
#include <array>
#include <cmath>

#include "master/import/cad/document.h"
#include "master/import/cad/shape_tree.h"
#include "master/import/crash_line.h"

namespace tessera::import::cad {
namespace {

// Loose faces that meet within the file's own resolution are sewn, but at least within the first
// share of the part's diagonal, and at most within the second one: faces of one solid are known to
// be apart by 7.5e-5, and files claim resolutions that are larger than their smallest parts.
constexpr double kSewingShareMin = 1e-5, kSewingShareMax = 1e-4;

constexpr const char* kUnitNames[] = {"MM", "INCH", "MM",  "MM", "FT", "MI",
                                      "M",  "KM",   "MIL", "UM", "CM", "UIN"};
constexpr std::array<std::array<double, 3>, 9> kColors = {{{0, 0, 0},
                                                           {0, 0, 0},
                                                           {1, 0, 0},
                                                           {0, 1, 0},
                                                           {0, 0, 1},
                                                           {1, 1, 0},
                                                           {1, 0, 1},
                                                           {0, 1, 1},
                                                           {1, 1, 1}}};

int face_count(const TopoDS_Shape& shape) {
  int count = 0;
  for (TopExp_Explorer face(shape, TopAbs_FACE); face.More(); face.Next()) ++count;
  return count;
}

void add_colors(const IGESControl_Reader& reader, Document& document) {
  const Handle(Transfer_TransientProcess) process =
      reader.WS()->TransferReader()->TransientProcess();
  const Handle(IGESData_IGESModel) model = reader.IGESModel();
  for (int i = 1; i <= model->NbEntities(); ++i) {
    const Handle(IGESData_IGESEntity) entity = model->Entity(i);
    std::optional<Quantity_Color> color;
    if (const auto own = Handle(IGESGraph_Color)::DownCast(entity->Color()); !own.IsNull()) {
      double r, g, b;
      own->RGBIntensity(r, g, b);
      const auto share = [](double percent) { return std::clamp(percent / 100, 0.0, 1.0); };
      color = Quantity_Color(share(r), share(g), share(b), Quantity_TOC_sRGB);
    } else if (const int rank = entity->RankColor(); rank >= 1 && rank <= 8) {
      const auto& c = kColors[static_cast<std::size_t>(rank)];
      color = Quantity_Color(c[0], c[1], c[2], Quantity_TOC_sRGB);
    }
    if (!color) continue;
    const TopoDS_Shape shape = TransferBRep::ShapeResult(process, entity);
    if (!shape.IsNull()) document.colors.emplace(shape.TShape().get(), *color);
  }
}

// Sews the faces of a part, so that those which meet share their edges. A part that would lose a
// face stays as it is.
void sew(Part& part, double resolution, Document& document) {
  if (part.shape.ShapeType() <= TopAbs_SOLID && part.shape.ShapeType() != TopAbs_COMPOUND) return;
  Bnd_Box box;
  BRepBndLib::Add(part.shape, box);
  if (box.IsVoid()) return;
  const double diagonal = std::sqrt(box.SquareExtent());
  // In this order a resolution that is no number is none.
  const double tolerance =
      std::max(kSewingShareMin * diagonal, std::min(resolution, kSewingShareMax * diagonal));
  BRepBuilderAPI_Sewing sewing(tolerance);
  sewing.Add(part.shape);
  sewing.Perform();
  const TopoDS_Shape sewn = sewing.SewedShape();
  if (sewn.IsNull() || face_count(sewn) != face_count(part.shape)) return;
  for (TopExp_Explorer face(part.shape, TopAbs_FACE); face.More(); face.Next()) {
    const auto color = document.color_of(face.Current());
    if (color)
      document.colors.emplace(sewing.ModifiedSubShape(face.Current()).TShape().get(), *color);
  }
  part.shape = sewn;
  document.sewing_tolerance = std::max(document.sewing_tolerance, tolerance);
  document.sewn_faces += static_cast<std::size_t>(face_count(sewn));
  document.sewn_edges += static_cast<std::size_t>(sewing.NbContigousEdges());
}

}  // namespace

Result<Document> read_iges(const std::string& path) {
  TESSERA_RETURN_IF_ERROR(check_end(path, {"T      1", "T0000001"}));
  IGESControl_Reader reader;
  // B-splines stay as they are; Open CASCADE would cut them where they are not smooth.
  Interface_Static::SetIVal("read.iges.bspline.continuity", 0);
  if (reader.ReadFile(path.c_str()) != IFSelect_RetDone || reader.IGESModel().IsNull())
    return Status::invalid_argument(path + ": is damaged: not readable as IGES");
  if (reader.IGESModel()->NbEntities() == 0) return no_surfaces(path, {});
  if (const std::string damage = first_damage(reader.IGESModel()); !damage.empty())
    CrashLine::note(damage);
  TESSERA_RETURN_IF_ERROR(check_circles(path, reader.IGESModel()));
  Document document;
  const IGESData_GlobalSection& section = reader.IGESModel()->GlobalSection();
  const int flag = section.UnitFlag();
  document.unit = flag >= 1 && flag <= 11 ? kUnitNames[flag] : "MM";
  Interface_Static::SetCVal("xstep.cascade.unit", document.unit.c_str());
  reader.TransferRoots();
  const TopoDS_Shape shape = reader.NbShapes() > 0 ? reader.OneShape() : TopoDS_Shape();
  if (!shape.IsNull()) add_parts(shape, document);
  if (document.parts.empty()) return no_surfaces(path, shape);
  add_colors(reader, document);
  for (Part& part : document.parts) sew(part, section.Resolution(), document);
  return document;
}

}  // namespace tessera::import::cad
