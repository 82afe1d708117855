#include "server/identity/method_permissions.h"

#include <array>

namespace dcloc::server {
namespace {

constexpr std::array kTable = {
    MethodPermission{"dcloc.v1.LocalizationService.Localize", Permission::kLocalize},

    MethodPermission{"dcloc.v1.MapService.ListMaps", Permission::kReadMaps},
    MethodPermission{"dcloc.v1.MapService.GetMap", Permission::kReadMaps},
    MethodPermission{"dcloc.v1.MapService.ListMapVersions", Permission::kReadMaps},
    MethodPermission{"dcloc.v1.MapService.GetMapVersion", Permission::kReadMaps},
    MethodPermission{"dcloc.v1.MapService.UploadMap", Permission::kManageMaps, Effect::kChanges},
    MethodPermission{"dcloc.v1.MapService.GetMapUpload", Permission::kManageMaps},
    MethodPermission{"dcloc.v1.MapService.DownloadMap", Permission::kReadMaps},
    MethodPermission{"dcloc.v1.MapService.ActivateMapVersion", Permission::kManageMaps,
                     Effect::kChanges},
    MethodPermission{"dcloc.v1.MapService.RollBackMap", Permission::kManageMaps, Effect::kChanges},
    MethodPermission{"dcloc.v1.MapService.SetMapCanary", Permission::kManageMaps, Effect::kChanges},
    MethodPermission{"dcloc.v1.MapService.FindCoverage", Permission::kReadCoverage},
    MethodPermission{"dcloc.v1.MapService.ReadMapTile", Permission::kReadMaps},
    MethodPermission{"dcloc.v1.MapService.StartMapBuild", Permission::kManageMaps,
                     Effect::kChanges},
    MethodPermission{"dcloc.v1.MapService.GetMapBuild", Permission::kReadMaps},
    MethodPermission{"dcloc.v1.MapService.ListMapBuilds", Permission::kReadMaps},
    MethodPermission{"dcloc.v1.MapService.CancelMapBuild", Permission::kManageMaps,
                     Effect::kChanges},
    MethodPermission{"dcloc.v1.MapService.DeleteMapVersion", Permission::kManageMaps,
                     Effect::kChanges},
    MethodPermission{"dcloc.v1.MapService.DeleteMap", Permission::kManageMaps, Effect::kChanges},

    MethodPermission{"dcloc.v1.PassService.SetPassConsent", Permission::kManageMaps,
                     Effect::kChanges},
    MethodPermission{"dcloc.v1.PassService.ListPassConsents", Permission::kReadMaps},
    MethodPermission{"dcloc.v1.PassService.ListPasses", Permission::kReadMaps},

    MethodPermission{"dcloc.v1.AdminService.ListReplicas", Permission::kReadServer},
    MethodPermission{"dcloc.v1.AdminService.GetServerState", Permission::kReadServer},
    MethodPermission{"dcloc.v1.AdminService.ListSessions", Permission::kReadSessions},
    MethodPermission{"dcloc.v1.AdminService.GetSession", Permission::kReadSessions},
    MethodPermission{"dcloc.v1.AdminService.WatchSession", Permission::kReadSessions},
    MethodPermission{"dcloc.v1.AdminService.EndSession", Permission::kManageSessions,
                     Effect::kChanges},
    MethodPermission{"dcloc.v1.AdminService.RecordSession", Permission::kManageSessions,
                     Effect::kChanges},
    MethodPermission{"dcloc.v1.AdminService.ProposePose", Permission::kManageSessions,
                     Effect::kChanges},
    MethodPermission{"dcloc.v1.AdminService.ListOperations", Permission::kReadSessions},
    MethodPermission{"dcloc.v1.AdminService.ListIdentities", Permission::kManageServer},
    MethodPermission{"dcloc.v1.AdminService.RevokeIdentity", Permission::kManageServer,
                     Effect::kChanges},
    MethodPermission{"dcloc.v1.AdminService.Drain", Permission::kManageServer, Effect::kChanges},
};

}  // namespace

std::span<const MethodPermission> MethodPermissions() { return kTable; }

}  // namespace dcloc::server
