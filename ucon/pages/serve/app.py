"""The application: pages, their scripts, and the data that they request, all below the token."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Mount, Route
from starlette.types import ASGIApp

from ucon.pages.serve.desk import Desk
from ucon.pages.serve.guard import Guard
from ucon.pages.serve.habits import habit_routes
from ucon.pages.serve.home_cards import Cards
from ucon.pages.serve.homes import home_routes
from ucon.pages.serve.play.games import Games
from ucon.pages.serve.play.routes import play_routes
from ucon.pages.serve.report_maker import ReportMaker
from ucon.pages.serve.run_list import RunList
from ucon.pages.serve.runs import run_routes
from ucon.pages.serve.shell import PAGES, asset, page
from ucon.pages.serve.studies import Studies
from ucon.pages.serve.study import study_routes


def make_app(desk: Desk, token: str, port: int) -> ASGIApp:
    """The guarded application.

    Args:
        desk: folders and habits.
        token: of the address.
        port: port at which it is served.
    """
    games, maker = Games(desk.out / "play", desk.homes), ReportMaker()

    @asynccontextmanager
    async def lifespan(_: Any) -> AsyncIterator[None]:
        yield
        games.close()
        maker.close()

    async def file(request: Request) -> Response:
        return asset(request.path_params["name"])

    routes = [
        Route("/", _page_of("start")),
        *(Route(f"/{name}", _page_of(name)) for name in PAGES),
        Route("/assets/{name}", file),
        *run_routes(RunList(desk.folders), maker),
        *habit_routes(desk.dataset),
        *home_routes(Cards(desk.dataset)),
        *play_routes(games),
        *study_routes(Studies(desk.out / "studies", desk.dataset)),
    ]
    return Guard(Starlette(routes=[Mount(f"/{token}", routes=routes)], lifespan=lifespan), token, port)


def _page_of(name: str) -> Any:
    async def shown(_: Request) -> Response:
        return page(name)

    return shown
