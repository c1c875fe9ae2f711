"""Label-setting search over ng-routes."""
