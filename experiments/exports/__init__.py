"""Do the models that a rig is exported to move as the rig does?"""
