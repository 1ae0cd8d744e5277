#include "town/street/street.h"

#include <fmt/format.h>

#include "town/street/layout.h"

namespace scanmill {

void addStreet(SceneBuilder& builder, Fields& fields, std::uint64_t seed, const Affine& worldFromStreet) {
  const street::Parameters parameters = street::readParameters(fields);
  fields.finish();
  const street::Layout layout(parameters, seed);
  builder.place(street::makeGround(builder, layout).mesh, worldFromStreet, "ground");
  builder.place(street::makeMarkings(builder, layout).mesh, worldFromStreet, "road markings");
  int number = 0;
  for (const street::House& house : layout.houses) {
    const street::Model model = street::makeHouse(builder, seed, house);
    builder.place(model.mesh, worldFromStreet * house.place, fmt::format("house {}", ++number));
  }
  street::populate(builder, layout, worldFromStreet);
}

}  // namespace scanmill
