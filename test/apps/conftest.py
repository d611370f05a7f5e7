# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""A browser, and a robot with the server of its page, which tests of applications share."""

import shutil

import pytest

from create_oi_ros.ros.parameters import Parameters
from support.ros import Ready
from support.web import LONG, OpenPage, PageClient, ready, served

CHROMIUM = ('chromium', 'chromium-browser', 'google-chrome')
"""Its names."""


@pytest.fixture(scope='module')
def browser():
    """Return a page of a real browser, which the tests of a file share."""
    pytest.importorskip('playwright', reason='no playwright here: see tools/pins.txt')
    found = next(filter(None, map(shutil.which, CHROMIUM)), None)
    if found is None:
        pytest.skip('no Chromium here: apt-get install chromium')
    from playwright.sync_api import sync_playwright
    with sync_playwright() as playwright:
        # In a container its sandbox may be impossible; only our own page is opened here.
        made = playwright.chromium.launch(
            executable_path=found, args=['--no-sandbox', '--disable-gpu'])
        yield OpenPage(made)
        made.close()


@pytest.fixture
def empty_page(browser):
    """Return this page, which shows nothing; in the end, it may not have complained."""
    yield browser
    browser.leave()


@pytest.fixture
def pages():
    """Return a function that opens a page; all are closed at the end."""
    opened = []

    def open_page(address, **arguments):
        opened.append(PageClient(address, **arguments))
        return opened[-1]
    yield open_page
    for page in opened:
        page.close()


USUAL = {'cmd_vel_timeout': LONG,
         'max_linear_acceleration': Parameters.max_linear_acceleration}
"""Parameters of the shared driver that tests change."""


class Shared:
    """A robot, its driver and the server, which tests share."""

    def __init__(self, stage) -> None:
        self.driver = Ready(stage)
        self.robot, self.ros = self.driver.robot, stage.ros
        self.address = served(stage)[1]

    def driving(self, open_page):
        """Return a page that drives the robot."""
        page = ready(open_page(self.address))
        page.drive(0.2, 0.0, lambda: page.known['pose']['speed'] > 0.1)
        return page


@pytest.fixture(scope='module')
def server(shared_stage):
    """Return a server that lasts."""
    return Shared(shared_stage)


@pytest.fixture
def shared(server):
    """Return it with its robot as new."""
    server.driver.renew()
    for name, value in USUAL.items():
        assert server.driver.set(name, value)
    return server
