#pragma once

#include "dcloc/v1/map_service.pb.h"
#include "server/maps/catalogue.h"

namespace dcloc::server::convert {

void ToProto(const MapRecord& record, v1::Map* message);
void ToProto(const MapVersionRecord& record, v1::MapVersion* message);

}  // namespace dcloc::server::convert
