// SPDX-License-Identifier: Apache-2.0
#include "tests/support/written_cad.h"

#include <BRepPrimAPI_MakeBox.hxx>
#include <BRep_Builder.hxx>
#include <IGESControl_Writer.hxx>
#include <IGESData_GlobalSection.hxx>
#include <IGESData_IGESModel.hxx>
#include <Interface_Static.hxx>
#include <STEPConstruct.hxx>
#include <STEPConstruct_Styles.hxx>
#include <STEPControl_Writer.hxx>
#include <StepBasic_Product.hxx>
#include <StepRepr_RepresentationContext.hxx>
#include <StepRepr_RepresentationItem.hxx>
#include <StepVisual_Colour.hxx>
#include <StepVisual_MechanicalDesignGeometricPresentationRepresentation.hxx>
#include <StepVisual_PresentationStyleAssignment.hxx>
#include <StepVisual_StyledItem.hxx>
#include <TopExp_Explorer.hxx>
#include <Transfer_FinderProcess.hxx>
#include <XSControl_TransferWriter.hxx>
#include <XSControl_WorkSession.hxx>
#include <cmath>
#include <fstream>
#include <gp_Ax1.hxx>
#include <gp_Trsf.hxx>
#include <iterator>

#include "master/import/cad/messages.h"
#include "tests/support/temp_folder.h"

namespace tessera::test {
namespace {

std::string text_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace

TopoDS_Compound assembly(std::initializer_list<TopoDS_Shape> parts) {
  TopoDS_Compound made;
  BRep_Builder builder;
  builder.MakeCompound(made);
  for (const TopoDS_Shape& part : parts) builder.Add(made, part);
  return made;
}

TopLoc_Location moved(double x, double y, double z) {
  gp_Trsf move;
  move.SetTranslation({x, y, z});
  return move;
}

TopoDS_Shape face_of(const TopoDS_Shape& shape, int number) {
  TopExp_Explorer face(shape, TopAbs_FACE);
  for (int i = 0; i < number; ++i) face.Next();
  return face.Current();
}

StepContent tray() {
  const TopoDS_Shape peg = BRepPrimAPI_MakeBox(1, 2, 3).Shape();
  const TopoDS_Shape board = BRepPrimAPI_MakeBox(60, 20, 1).Shape();
  const TopoDS_Compound pair =
      assembly({peg.Located(moved(0, 0, 1)), peg.Located(moved(0, 10, 1))});
  gp_Trsf turn;
  turn.SetRotation(gp_Ax1({0, 0, 0}, {0, 0, 1}), std::acos(-1.0) / 2);
  const TopLoc_Location turned = moved(50, 0, 0) * TopLoc_Location(turn);
  return {assembly({board, pair.Located(moved(5, 0, 0)), pair.Located(turned)}),
          {{peg, Quantity_Color(1, 0, 0, Quantity_TOC_sRGB)},
           {face_of(peg, 2), Quantity_Color(0, 0.5, 1, Quantity_TOC_sRGB)}},
          {"tray", "board", "pair", "peg"}};
}

std::string step_text(const StepContent& content) {
  const import::cad::Messages quiet;
  const TempFolder folder;
  STEPControl_Writer writer;
  Interface_Static::SetIVal("write.step.assembly", 1);
  Interface_Static::SetCVal("write.step.unit", "MM");
  Interface_Static::SetCVal("xstep.cascade.unit", "MM");
  if (writer.Transfer(content.shape, STEPControl_AsIs) != IFSelect_RetDone) return {};
  const Handle(Interface_InterfaceModel) model = writer.WS()->Model();
  STEPConstruct_Styles styles(writer.WS());
  for (const auto& [shape, color] : content.colors) {
    const Handle(StepVisual_Colour) encoded = STEPConstruct_Styles::EncodeColor(color);
    const Handle(StepRepr_RepresentationItem) item =
        STEPConstruct::FindEntity(writer.WS()->TransferWriter()->FinderProcess(), shape);
    if (item.IsNull()) return {};
    styles.AddStyle(item, styles.MakeColorPSA(item, encoded, encoded, encoded, 0), nullptr);
  }
  if (!content.colors.empty()) {
    const auto context = styles.FindContext(content.colors.front().first);
    Handle(StepVisual_MechanicalDesignGeometricPresentationRepresentation) made;
    if (context.IsNull() || !styles.CreateMDGPR(context, made)) return {};
    model->AddWithRefs(made, writer.WS()->Protocol());
  }
  auto name = content.product_names.begin();
  for (int i = 1; i <= model->NbEntities() && name != content.product_names.end(); ++i) {
    if (const auto product = Handle(StepBasic_Product)::DownCast(model->Value(i));
        !product.IsNull())
      product->SetName(new TCollection_HAsciiString((name++)->c_str()));
  }
  const std::string path = folder / "written.step";
  return writer.Write(path.c_str()) == IFSelect_RetDone ? text_of(path) : "";
}

std::string iges_text(const std::vector<TopoDS_Shape>& faces, double resolution) {
  const import::cad::Messages quiet;
  const TempFolder folder;
  IGESControl_Writer writer("MM", 0);
  for (const TopoDS_Shape& face : faces)
    if (!writer.AddShape(face)) return {};
  writer.ComputeModel();
  IGESData_GlobalSection section = writer.Model()->GlobalSection();
  section.SetResolution(resolution);
  writer.Model()->SetGlobalSection(section);
  const std::string path = folder / "written.igs";
  return writer.Write(path.c_str()) ? text_of(path) : "";
}

}  // namespace tessera::test
