"""`followspot certs`: a certificate authority, and certificates for the hosts that may communicate."""

from __future__ import annotations

import argparse
import json
from datetime import UTC, datetime
from pathlib import Path

from followspot.errors import FollowspotError
from followspot.plugins.hooks import Command

_ROLES = ("camera", "worker", "operator", "router")


def _configure_dir(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--dir", default="certs", metavar="DIR", help="folder of the authority (default: certs)"
    )


def _configure_host(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("name", metavar="NAME", help="name of the host in rooms and placements")
    parser.add_argument("--role", choices=_ROLES, help="what the host may do (default: camera)")
    parser.add_argument(
        "--address",
        action="append",
        default=[],
        metavar="IP_OR_NAME",
        help="address at which others connect to the host; repeatable; its name and loopback are included",
    )
    parser.add_argument(
        "--days", type=_days, default=825, metavar="N", help="days of validity (default: 825)"
    )
    parser.add_argument("--renew", action="store_true", help="replace the certificate of a host that has one")
    _configure_dir(parser)


def _configure_remove(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("name", metavar="NAME", help="name of the host")
    _configure_dir(parser)


def _configure_show(parser: argparse.ArgumentParser) -> None:
    _configure_dir(parser)
    parser.add_argument("--json", action="store_true", help="print one JSON object")


def _init(args: argparse.Namespace) -> int:
    """Make a certificate authority, which decides which hosts may join.

    Example:
      followspot certs init --dir certs
    """
    from followspot.security.authority import AUTHORITY, create_authority

    authority = create_authority(Path(args.dir))
    print(f"authority in {args.dir}, until {authority.expires:%Y-%m-%d}")
    print(f"keep {Path(args.dir) / AUTHORITY} on this machine: its key can let any host in")
    print(f"next: followspot certs host NAME --role operator --dir {args.dir}")
    return 0


def _host(args: argparse.Namespace) -> int:
    """Make the certificate of a host, in a folder to copy to that host.

    Examples:
      followspot certs host operator --role operator
      followspot certs host pc-left --role camera --address 192.168.0.7

    camera, worker: runs an agent, and sends the messages of its own stages; operator: also starts, changes
    and stops runs; router: forwards the messages of other hosts.
    """
    from followspot.security.authority import Authority

    authority = Authority(Path(args.dir))
    known = {member.name: member for member in authority.members}
    role = args.role or (known[args.name].role if args.name in known else "camera")
    folder = authority.add(args.name, role, args.address, args.days, renew=args.renew)
    print(f"{args.name} ({role}): copy {folder} to that host, and pass it to --certificates there")
    _tell_others(folder.parent, [name for name in known if name != args.name])
    return 0


def _remove(args: argparse.Namespace) -> int:
    """Refuse a host from now on.

    Example:
      followspot certs remove pc-left
    """
    from followspot.security.authority import Authority

    authority = Authority(Path(args.dir))
    authority.remove(args.name)
    print(f"{args.name} is removed; every host with the new list refuses it")
    _tell_others(Path(args.dir), [member.name for member in authority.members])
    return 0


def _tell_others(folder: Path, names: list[str]) -> None:
    if names:
        files = ", ".join(str(folder / name / "hosts.json") for name in sorted(names))
        print(f"the list of hosts has changed; copy it to each host, and restart agents and routers: {files}")


def _show(args: argparse.Namespace) -> int:
    """List hosts, roles, and how long their certificates are valid; a host's own folder works, too.

    Example:
      followspot certs show --dir certs
    """
    from followspot.transport.host_registry import REGISTRY, read_host_registry

    path = Path(args.dir) / REGISTRY
    if not path.is_file():
        raise FollowspotError(f"there is no authority in {args.dir}; followspot certs init --dir {args.dir}")
    own, members = read_host_registry(path)
    if args.json:
        hosts = [{"name": m.name, "role": m.role, "expires": m.expires.isoformat()} for m in members]
        print(json.dumps({"own": own, "hosts": hosts}))
        return 0
    now = datetime.now(UTC)
    for member in sorted(members, key=lambda member: member.name):
        days = (member.expires - now).days
        left = f"{days} days left" if days >= 0 else "EXPIRED"
        print(f"{member.name:<24} {member.role:<9} until {member.expires:%Y-%m-%d}  {left}")
    return 0


def _days(text: str) -> int:
    days = int(text)
    if not 1 <= days <= 3650:
        raise argparse.ArgumentTypeError("from 1 to 3650 days")
    return days


INIT = Command("init", _configure_dir, _init, parent="certs")
HOST = Command("host", _configure_host, _host, parent="certs")
REMOVE = Command("remove", _configure_remove, _remove, parent="certs")
SHOW = Command("show", _configure_show, _show, parent="certs")
COMMANDS = (INIT, HOST, REMOVE, SHOW)
